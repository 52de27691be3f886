/** @file
 * What a surface adds to the contact: relief, vibration and the transient of an impact. docs/surfaces.md tells the
 * laws. For the guard a relief is passive, as its surface is, and the others are active.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/math.h"
#include "rt/render/proxy/proxy.h"
#include "rt/render/surface/transient.h"
#include "rt/render/surface/vibration.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Forces on the hand, in W [N]. */
struct SurfaceForces {
  Vec3 relief = Vec3::Zero();     ///< By which the contact's own becomes that of the lowered surface.
  Vec3 vibration = Vec3::Zero();  ///< Of a tool that is drawn over it.
  Vec3 transient = Vec3::Zero();  ///< Of an impact.
  double stored = 0;              ///< Energy in the springs of the contact, as the relief leaves it [J].
  Vec3 carried = Vec3::Zero();    ///< Power, by axis, that bodies which move put into the relief [W].

  [[nodiscard]] Vec3 texture() const HD_RT { return relief + vibration; }
};

/** Effects of one device point. Servo thread only; deterministic. */
class SurfaceEffects {
 public:
  /** Points of different seeds vibrate differently. */
  explicit SurfaceEffects(std::uint64_t seed = 0) noexcept : vibration_(seed) {}

  /**
   * Steps in which the hand's coordinates come [m], and the speed that they may feign of one at rest [m/s]: neither
   * makes an impact or a vibration. Not positive counts as 0, as at the start.
   */
  void setResolution(double step, double speed) HD_RT {
    away_ = step > 0 ? kAway * step : 0;
    noise_ = speed > 0 ? speed : 0;
  }
  /**
   * After the proxy has found `contact`, with what is `holding` it, for a hand at `hip` that moves at `v`. Without
   * contact, or above the ground of a relief's hollow, there is no texture; a transient sounds on until it has died
   * out.
   */
  [[nodiscard]] SurfaceForces step(const Scene& scene, const SurfaceContact& contact,
                                   std::span<const HoldingSurface> holding, const Vec3& hip, const Vec3& v) HD_RT;
  void reset() HD_RT {
    transient_.reset();
    vibration_.rest();
    felt_.id.fill(0);
  }

 private:
  static constexpr double kAway = 4;  ///< Steps that a hand must go to have left: readings at rest differ by two.

  /** Objects whose surfaces, as their relief lowers them, push, or have and are not left yet. */
  struct Felt {
    std::array<std::uint32_t, kMaxHolding + 1> id{};  ///< 0 for none.
    std::array<Vec3, kMaxHolding + 1> at;             ///< The hand then, in the object's frame.
  };

  void strike(const Scene& scene, const SurfaceContact& contact, std::span<const HoldingSurface> holding, bool felt,
              const Vec3& hip, const Vec3& v) HD_RT;

  Transient transient_;
  Vibration vibration_;
  double away_ = 0;   ///< [m]
  double noise_ = 0;  ///< Of the hand's speed [m/s].
  Felt felt_;         ///< In the last tick.
};

}  // namespace hapticd
