/** @file
 * Smooth shading of coarse meshes: the force is turned from the facets' normal to that of the smooth surface they stand
 * for (Ruspini, Kolarov, Khatib, "The haptic display of complex graphical environments", SIGGRAPH 1997, section 4.3:
 * force shading; smooth_normal.h tells which normal that is).
 */
#pragma once

#include <span>

#include "rt/render/proxy/proxy.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Shading of one device point. Servo thread only; deterministic. */
class Shading {
 public:
  /**
   * Turns contact.force to contact.smooth where a surface touched asks for it (SurfaceParameters::smooth_cosine), for a
   * hand that moves at v_W [m/s]. Each surface `holding` the proxy has its smooth normal, and of several each has as
   * much say as it presses. The force keeps its magnitude and its part across the normal, so a friction cone stays one;
   * the proxy is not touched. Damping is not turned but made anew along the turned normal: it takes energy in any case.
   * Beyond 60 degrees nothing is turned.
   */
  void step(const Scene& scene, std::span<const HoldingSurface> holding, const Vec3& v_W,
            SurfaceContact& contact) HD_RT;
  void reset() HD_RT { object_ = 0; }

 private:
  [[nodiscard]] Vec3 lagFelt(const SceneObject& object, const SurfaceContact& contact, const Vec3& spring,
                             const Vec3& smooth) HD_RT;

  /** What friction keeps from the last tick, in the frame of that object; 0: nothing. */
  std::uint32_t object_ = 0;
  Vec3 spring_ = Vec3::Zero();  ///< From hip to proxy [m].
  Vec3 at_ = Vec3::Zero();      ///< The proxy.
  Vec3 smooth_ = Vec3::Zero();  ///< The normal felt,
  Vec3 felt_ = Vec3::Zero();    ///< and across it what friction was felt, in depths:
  Vec3 offset_ = Vec3::Zero();  ///< by so much more than the proxy's.
};

inline constexpr double kLeastTurnCosine = 0.5;  ///< No force is turned by more than 60 degrees.

}  // namespace hapticd
