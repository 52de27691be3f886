/** @file
 * Two solids that are in each other: a point within both, and the least way that parts them.
 */
#pragma once

#include <cstdint>

#include "rt/scene/scene.h"

namespace hapticd {

/** One of two bodies that may be in each other. */
struct Solid {
  const Shape& shape;
  Pose X_WO;
};

/** What parts two solids. */
struct Parting {
  Vec3 n = Vec3::UnitX();  ///< Unit: the second goes along it, or the first back.
  double way = 0;          ///< So far they reach past each other along it [m].
  double first = 0;        ///< How far the first reaches along n from its middle, ...
  double second = 0;       ///< ... and the second back along n from its own [m].
};

/** The middle of a solid, in the world: of a mesh, of the box about it. */
[[nodiscard]] Vec3 middleOf(const Solid& solid) HD_RT;

/**
 * The least way along the axes of both, or across two of them, or from middle to middle; where one is curved, along
 * what is shorter near those. A mesh counts as the box about it. Neither a plane nor a group. The two in the same order
 * part the same way, whoever asks.
 */
[[nodiscard]] Parting leastParting(const Solid& first, const Solid& second) HD_RT;

inline constexpr double kWithin = 5e-5;  ///< [m]

/**
 * Looks for a point deeper than kWithin in both; what it finds is one, of whatever shape they are, but it may find none
 * in solids that are not convex. `limit`: of a mesh's work in all; `work` is added to.
 */
[[nodiscard]] bool findWithin(const Solid& first, const Solid& second, std::uint32_t limit, std::uint32_t& work) HD_RT;

}  // namespace hapticd
