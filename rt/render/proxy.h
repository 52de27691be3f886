/** @file
 * 3-DOF rendering by a proxy (god-object) with the thesis's two-state friction cone (section 2.2.1).
 */
#pragma once

#include <cstdint>

#include "rt/base/math.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Contact of one device point. Vectors in W. */
struct SurfaceContact {
  Vec3 force = Vec3::Zero();   ///< On the hand [N].
  Vec3 proxy = Vec3::Zero();   ///< [m]
  Vec3 normal = Vec3::Zero();  ///< Outward, unit; zero in free space.
  double depth = 0;            ///< |hip - proxy| along the normal [m].
  std::uint32_t object = 0;    ///< Id of the object in contact, 0 for none.
  bool slip = false;
  bool touch = false;      ///< Contact began this tick.
  bool untouch = false;    ///< Contact ended this tick.
  std::uint32_t work = 0;  ///< Tree nodes and triangles visited: bounded, see kMaxWork.
};

/** Proxy of one device point. Servo thread only; deterministic. */
class ProxyRenderer {
 public:
  /** Most nodes and triangles one step visits. Beyond it the proxy stays where it was: late, never wrong side. */
  static constexpr std::uint32_t kMaxWork = 200'000;

  /** Starts anew with the proxy at the hip. */
  void reset(const Vec3& hip_W) HD_RT;

  /**
   * Moves the proxy toward `hip_W` and computes the force k (proxy - hip) plus damping against the relative velocity
   * of hip and surface along the normal (never pulling). Objects' motion since the last tick is swept.
   */
  void step(const Scene& scene, const Vec3& hip_W, const Vec3& v_W, double dt, SurfaceContact& contact) HD_RT;

 private:
  Vec3 proxy_ = Vec3::Zero();
  std::uint32_t object_ = 0;      ///< Object of the last contact.
  Vec3 anchor_O_ = Vec3::Zero();  ///< The proxy in that object's frame.
  bool slip_ = false;
  bool started_ = false;
};

}  // namespace hapticd
