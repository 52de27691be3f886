/** @file
 * The five bars of a pantograph: two motors, two links of length l, two of length L that meet at the grip. Pure,
 * real-time safe.
 *
 * Device's plane: motor 1 at the origin, motor 2 at (d, 0), the grip at positive y (toward the operator).
 */
#pragma once

#include <Eigen/Core>

#include "rt/base/contract.h"

namespace hapticd::pantograph {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

/** [m] */
struct Bars {
  double l = 0.05, L = 0.07, d = 0.02;
};

struct Grip {
  Vec2 p = Vec2::Zero();
  Mat2 jacobian = Mat2::Zero();  ///< d p / d(angles of the motors) [m/rad].
  bool reachable = false;        ///< False: the bars do not meet, or lie in one line, where they push without bound.
};

/** Angles of the motors from the x axis [rad]. */
[[nodiscard]] Grip gripAt(const Bars& bars, const Vec2& angles) HD_RT;

}  // namespace hapticd::pantograph
