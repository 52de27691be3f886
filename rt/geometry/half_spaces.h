/** @file
 * The nearest point of an intersection of few half-spaces: the active set of constraint-based rendering (Zilles and
 * Salisbury, IROS 1995, by Lagrange multipliers; here by trying the active sets, which needs no multiplier).
 */
#pragma once

#include <cstdint>

#include "rt/base/math.h"

namespace hapticd {

/** Allowed where normal . x >= offset. */
struct HalfSpace {
  Vec3 normal = Vec3::Zero();  ///< Unit.
  double offset = 0;

  [[nodiscard]] double height(const Vec3& x) const HD_RT { return normal.dot(x) - offset; }
};

inline constexpr int kMaxHalfSpaces = 4;

/**
 * Whether a set of planes, by bit, is one plane. (std::has_single_bit counts bits, by a call where no wider
 * instructions are allowed.)
 */
[[nodiscard]] constexpr bool isOneBit(std::uint32_t mask) HD_RT { return mask != 0 && (mask & (mask - 1)) == 0; }

/**
 * The point nearest to x on all the boundary planes named by `mask` (at most three of them). False, x untouched, if
 * two are parallel or three meet in no point. Servo-safe.
 */
[[nodiscard]] bool nearestOnPlanes(const HalfSpace* planes, std::uint32_t mask, Vec3& x) HD_RT;

/**
 * Moves x to the nearest point inside all `count` half-spaces (at most kMaxHalfSpaces); `active` receives the planes
 * it then lies on. A point within `tolerance` behind a plane counts as inside. False, x untouched, if there is none.
 * Servo-safe.
 */
[[nodiscard]] bool nearestInside(const HalfSpace* planes, int count, double tolerance, Vec3& x,
                                 std::uint32_t& active) HD_RT;

}  // namespace hapticd
