/** @file
 * Textures as the servo reads them: views into memory that the control thread made, checked and locked.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "rt/command.h"

namespace hapticd {

inline constexpr std::uint32_t kVibrationOrder = 16;  ///< Reflection coefficients of a model at the servo's rate.

/** Heights by grey, row by row from the picture's upper edge. Both sides are at least 2. */
struct ReliefView {
  const std::uint16_t* pixel = nullptr;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

/** Vibration at one speed and force, at the servo's rate: an all-pole lattice filter fed with white noise. */
struct VibrationModel {
  double speed = 0;                                  ///< [m/s]
  double force = 0;                                  ///< [N]
  double power = 0;                                  ///< Variance of the acceleration [m^2/s^4].
  std::array<double, kVibrationOrder> reflection{};  ///< Each within (-1, 1): stable, and so is every mean of some.
};

/** Models and the triangles between them over the plane of speed and force. */
struct VibrationView {
  using Corners = std::array<std::uint16_t, 3>;
  const VibrationModel* model = nullptr;
  const Corners* triangle = nullptr;
  std::uint32_t triangles = 0;
  double least_speed = 0, most_speed = 0;  ///< Of those models [m/s]: below it fades to silence, above it stays.
  double least_force = 0, most_force = 0;  ///< [N], likewise.

  /** Finds these bounds; of models that no triangle names a recording may know nothing. There is a triangle. */
  void findBounds() noexcept {
    const VibrationModel& first = model[triangle[0][0]];
    least_speed = most_speed = first.speed;
    least_force = most_force = first.force;
    for (std::uint32_t t = 0; t < triangles; ++t) {
      for (const std::uint16_t corner : triangle[t]) {
        least_speed = std::min(least_speed, model[corner].speed);
        most_speed = std::max(most_speed, model[corner].speed);
        least_force = std::min(least_force, model[corner].force);
        most_force = std::max(most_force, model[corner].force);
      }
    }
  }
};

/** One texture: of the two views the one that is not empty. */
struct TextureView {
  ReliefView relief;
  VibrationView vibration;
};

/** What a surface does beyond its material. */
struct Surface {
  SurfaceParameters parameters{};
  const ReliefView* relief = nullptr;
  const VibrationView* vibration = nullptr;
  std::uint32_t changes = 0;  ///< Orders that have set it; wraps.
};

}  // namespace hapticd
