/** @file
 * What a surface feels like beyond its material, in a user's terms (docs/surfaces.md).
 */
#pragma once

#include <cstdint>
#include <string>

#include "rt/base/error.h"
#include "rt/command.h"

namespace hapticd {

class TextureStore;

/** As Surface in control.capnp, whose defaults these are: nothing is on, and whatever is turned on is moderate. */
struct SurfaceSpec {
  double smooth_deg = 0;            ///< Edges that bend less than this are shaded round [degree].
  double transient_gain = 0;        ///< Force per speed of impact [N s/m].
  double transient_hz = 150;        ///< What an impact rings at.
  double transient_decay_s = 0.01;  ///< Time in which it falls to 1/e.
  std::uint64_t relief = 0;         ///< Texture, 0 for none.
  double relief_depth = 0.2e-3;     ///< From white down to black [m].
  double relief_width = 0.1;        ///< Of the picture [m].
  double relief_height = 0.1;
  std::uint64_t vibration = 0;   ///< Texture, 0 for none.
  double vibration_mass = 0.05;  ///< Force per acceleration [kg]: handle and hand of the paper's device.

  [[nodiscard]] bool operator==(const SurfaceSpec&) const = default;
};

inline constexpr double kMostSlope = 2;  ///< Of a relief.

/** Names the field at fault under `where`; for a relief too steep, the pixel. */
[[nodiscard]] Result<void> checkSurface(const SurfaceSpec& surface, const TextureStore& textures,
                                        const std::string& where);

/** For a servo of that period. The spec has been checked. */
[[nodiscard]] SurfaceParameters surfaceParameters(const SurfaceSpec& surface, const TextureStore& textures,
                                                  std::int64_t period_ns);

}  // namespace hapticd
