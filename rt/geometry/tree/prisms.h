/** @file
 * Many triangles at once against a ball that moves a little: which of them it may meet. Single precision, widened, so
 * that none is missed; the exact tests of the few left decide.
 *
 * A triangle is seen as its plane and the three planes that stand on its edges. From the height above the one and the
 * distance beyond the others follows a bound of the distance to the triangle. No plane's normal is made a unit vector:
 * squares are compared with squares, and a prism takes no division and no root, for most are asked only a few times.
 *
 * As boxes.h, free of inline code: files compiled for wider instructions include this.
 */
#pragma once

#include <cstdint>

namespace hapticd {

inline constexpr int kPrismWidth = 8;
inline constexpr int kPrismBlocks = 64;  ///< That are asked at a time, at most: a bit each.

/** Eight triangles, coordinate by coordinate, in a frame about some place. A plane is normal . x = offset. */
struct PrismBlock {
  alignas(32) float normal[3][kPrismWidth];
  float offset[kPrismWidth];
  float squared[kPrismWidth];     ///< Of the normal.
  float side[3][3][kPrismWidth];  ///< Outward normals of the planes on the edges.
  float side_offset[3][kPrismWidth];
  float side_squared[3][kPrismWidth];  ///< Of the side's normal over that of the face.
  std::uint32_t first;                 ///< The number of the first triangle: the others follow it.
  std::uint32_t used;                  ///< A bit each.
};

/** Boxes about eight blocks, in the same frame. */
struct PrismBoxes {
  alignas(32) float lower[3][kPrismWidth];
  float upper[3][kPrismWidth];
};

/** Where a frame of prisms is, and how long its unit is: the radius of the ball in which questions are asked. */
struct PrismFrame {
  float origin[3];  ///< [m]
  float inverse;    ///< Of the unit [1/m].
};

/** A ball whose centre moves from a to b, in the triangles' frame. */
struct PrismSweep {
  float a[3];
  float b[3];
  float radius_squared;
  bool still;            ///< a and b are one: prisms are asked with a alone.
  float behind_squared;  ///< What stays farther than this behind its plane is not met.
};

/**
 * Makes prisms of `count` triangles, 1 to 8, whose corners stand one after the other, nine coordinates a triangle;
 * lanes left over repeat the last. Leaves `first` and `used` alone. Bit i of the answer: triangle i is so large, narrow
 * or small that single precision will not do for it.
 */
using MakePrisms = std::uint32_t (*)(const float* corners, std::uint32_t count, const PrismFrame& frame,
                                     PrismBlock& block) noexcept;
std::uint32_t makePrismsPortable(const float* corners, std::uint32_t count, const PrismFrame& frame,
                                 PrismBlock& block) noexcept;
std::uint32_t makePrismsAvx2(const float* corners, std::uint32_t count, const PrismFrame& frame,
                             PrismBlock& block) noexcept;

/** Where a plane is put that is farther: it answers alike for all of the ball, and would only round worse. */
inline constexpr float kPrismFar = 8;
/**
 * (Longest edge squared over twice the area, times 1 + longest edge), squared: above this a triangle is left to
 * doubles; the second factor's square is taken as twice the sum of the squares, which is no less.
 */
inline constexpr float kPrismRough = 64;
/** And below this square of twice its area, lest higher powers underflow. */
inline constexpr float kPrismSmall = 1e-20F;

/**
 * Bit k: the ball may meet what is in box k of the first `blocks`, at most kPrismBlocks. What is farther than the
 * radius from a box about the way is not met.
 */
using NearPrisms = std::uint64_t (*)(const PrismBoxes* boxes, std::uint32_t blocks, const PrismSweep& sweep) noexcept;

/** Of one question; counted where the processor is known to count bits. */
struct PrismsReached {
  std::uint32_t blocks;     ///< That were looked at.
  std::uint32_t triangles;  ///< That may be met.
};

/**
 * Lists the triangles of blocks k, for each bit k of `blocks`, that may be met, block by block in rising order, and
 * counts them. There must be room for eight of each block. No branch is to be guessed for a block or a triangle:
 * guesses cost more than all the rest, for what is met is different each time. The implementations of boxes.h's paths;
 * all give the same bits. Servo-safe.
 */
using ReachPrisms = PrismsReached (*)(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                                      std::uint32_t* triangles) noexcept;
PrismsReached reachPrismsPortable(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                                  std::uint32_t* triangles) noexcept;
/** Only on x86-64. */
PrismsReached reachPrismsAvx2(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                              std::uint32_t* triangles) noexcept;

}  // namespace hapticd
