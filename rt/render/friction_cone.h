/** @file
 * When what slips sticks again: the thesis's two-state friction cone (section 2.2.1) on surfaces that are not flat.
 */
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/base/contract.h"

namespace hapticd {

inline constexpr double kConeRounding = 1e-9;  ///< Of the radius of a cone.

/**
 * How far a proxy that slips may be from where it would be without friction before it sticks again [m]: on a plane the
 * border of the dynamic cone.
 *
 * On a curve the normal turns as the proxy comes to that border, and in a hollow it is left inside; whoever goes on is
 * not meant to stick there. So slip ends where the hand comes back from where the proxy was left, or that is far
 * inside. And a reading that falls back by a step on each axis is no way back: it takes sqrt(3) steps off the one
 * length or the other.
 *
 * @param left  What it was left at, in depths.
 * @param friction_dynamic  Coefficient of the material; times what damping leaves of the normal force.
 * @param depth  Of the hand below the surface [m].
 * @param step  By which a reading of the hand's place may be off on each axis, from one to the next [m]. Not positive
 *              counts as 0.
 */
[[nodiscard]] inline double slipEnds(double left, double friction_dynamic, double depth, double step = 0) HD_RT {
  constexpr double kLeast = 0.5;  // Of the cone: what comes so far inside does not go on.
  constexpr double kSqrt3 = 1.7320508075688772;
  const double border = std::clamp(left, kLeast * friction_dynamic, friction_dynamic) * depth;
  const double fall = step > 0 ? kSqrt3 * step * std::sqrt(1 + friction_dynamic * friction_dynamic) : 0.0;
  return std::max(border - fall, kLeast * border) * (1 - kConeRounding);
}

}  // namespace hapticd
