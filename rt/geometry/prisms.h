/** @file
 * Many triangles at once against a ball that moves a little: which of them it may meet. Single precision, widened, so
 * that none is missed; the exact tests of the few left decide.
 *
 * A triangle is seen as its plane and the three planes that stand on its edges. From the height above the one and the
 * distance beyond the others follows a bound of the distance to the triangle, without a division or a root.
 *
 * As boxes.h, free of inline code: files compiled for wider instructions include this.
 */
#pragma once

#include <cstdint>

namespace hapticd {

inline constexpr int kPrismWidth = 8;

/** Eight triangles, coordinate by coordinate, about some centre. A plane is normal . x = offset. */
struct PrismBlock {
  alignas(32) float normal[3][kPrismWidth];
  float offset[kPrismWidth];
  float side[3][3][kPrismWidth];  ///< Outward normals of the planes on the edges.
  float side_offset[3][kPrismWidth];
  std::uint32_t triangle[kPrismWidth];
};

/** Their corners, about the same centre: v[corner][axis]. */
struct PrismCorners {
  alignas(32) float v[3][3][kPrismWidth];
};

/** A ball whose centre moves from a to b, both about the same centre as the triangles. */
struct PrismSweep {
  float a[3];
  float b[3];
  float radius_squared;  ///< [m^2]
  bool still;            ///< a and b are one: asked with a alone.
  float behind;          ///< What stays farther than this behind its plane is not met [m].
};

/**
 * Makes eight prisms of their corners, for questions within `radius` of the centre; planes farther than kPrismFar radii
 * are put there. Bit i of the answer: triangle i is so large or narrow that single precision will not do for it.
 */
using MakePrisms = std::uint32_t (*)(const PrismCorners& corners, float radius, PrismBlock& block) noexcept;
std::uint32_t makePrismsPortable(const PrismCorners& corners, float radius, PrismBlock& block) noexcept;
std::uint32_t makePrismsAvx2(const PrismCorners& corners, float radius, PrismBlock& block) noexcept;

/** A plane beyond answers alike for all of the ball, and would only round worse. */
inline constexpr float kPrismFar = 8;
/** Longest edge squared over twice the area, times (1 + longest edge over radius): above this it is left to doubles. */
inline constexpr float kPrismRough = 8;

/**
 * Bit i of mask[k], for each bit k of `blocks`: triangle i of block k may be met. The implementations of boxes.h's
 * paths; all give the same bits. Servo-safe.
 */
using ReachPrisms = void (*)(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                             std::uint8_t* mask) noexcept;
void reachPrismsPortable(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                         std::uint8_t* mask) noexcept;
/** Only on x86-64. */
void reachPrismsAvx2(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                     std::uint8_t* mask) noexcept;

}  // namespace hapticd
