/** @file
 * How steep a relief is anywhere between its pixels, whatever their sides turn out to be.
 */
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace hapticd {

/** Slopes of a relief, of all grey a pixel, that go together at some place. */
struct ReliefSlope {
  double across = 0, down = 0;        ///< 0 to 1.
  std::uint32_t column = 0, row = 0;  ///< A pixel beside it.
};

/**
 * At most a few hundred. Laid out with pixels of any sides, the relief is nowhere steeper (reliefAt()) than the
 * steepest of these is, and next to nothing less steep than that.
 */
[[nodiscard]] std::vector<ReliefSlope> reliefSlopes(std::span<const std::uint16_t> pixels, std::uint32_t width,
                                                    std::uint32_t height);

}  // namespace hapticd
