/** @file
 * What a surface adds to the contact: relief, vibration and the transient of an impact. docs/surfaces.md tells the
 * laws. All of it is active for the guard and has its own share in the published force.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/math.h"
#include "rt/render/proxy.h"
#include "rt/render/transient.h"
#include "rt/render/vibration.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Forces on the hand, in W [N]. */
struct SurfaceForces {
  Vec3 texture = Vec3::Zero();    ///< Relief and vibration.
  Vec3 transient = Vec3::Zero();  ///< Of an impact.
};

/** Effects of one device point. Servo thread only; deterministic. */
class SurfaceEffects {
 public:
  /** Points of different seeds vibrate differently. */
  explicit SurfaceEffects(std::uint64_t seed = 0) noexcept : vibration_(seed) {}

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
    felt_.fill(0);
  }

 private:
  /** Ids, 0 for none. */
  using Felt = std::array<std::uint32_t, kMaxHolding + 1>;

  void strike(const Scene& scene, const SurfaceContact& contact, std::span<const HoldingSurface> holding, bool felt,
              const Vec3& v) HD_RT;

  Transient transient_;
  Vibration vibration_;
  Felt felt_{};  ///< The objects whose surfaces, as their relief lowers them, pushed in the last tick.
};

}  // namespace hapticd
