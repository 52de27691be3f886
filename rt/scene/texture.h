/** @file
 * Textures as the servo reads them: views into memory that the control thread made, checked and locked.
 */
#pragma once

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
  double least_speed = 0, most_speed = 0;  ///< Of the models [m/s]: below it fades to silence, above it stays.
  double least_force = 0, most_force = 0;  ///< [N], likewise.
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
};

}  // namespace hapticd
