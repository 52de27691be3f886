/** @file
 * A texture as a client uploaded it (proto/texture.h), checked.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "daemon/scene/texture/relief_slopes.h"
#include "rt/base/error.h"

namespace hapticd {

/** The steepest step between two neighbouring pixels along one side of a relief, of all grey. */
struct SteepestStep {
  double grey = 0;                    ///< 0 to 1.
  std::uint32_t column = 0, row = 0;  ///< The pixel left of it, or above it.
};

struct Relief {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint16_t> pixels;
  SteepestStep across, down;
  std::vector<ReliefSlope> slopes;
};

/** An autoregressive model at the rate it was made for: y[n] = e[n] - sum a[i] y[n - 1 - i]. */
struct RecordedModel {
  double speed = 0, force = 0;  ///< [m/s, N]
  double variance = 0;          ///< Of e [m^2/s^4].
  std::vector<double> a;
};

struct RecordedVibration {
  double rate_hz = 0;
  std::vector<RecordedModel> models;
  std::vector<std::array<std::uint16_t, 3>> triangles;
};

/** Of the two the one that is not empty. */
struct Texture {
  Relief relief;
  RecordedVibration vibration;
  [[nodiscard]] bool isRelief() const noexcept { return !relief.pixels.empty(); }
};

/** Everything of an upload is checked: kInvalidArgument names the field, the model or the triangle at fault. */
[[nodiscard]] Result<Texture> parseTexture(std::span<const std::byte> bytes);

}  // namespace hapticd
