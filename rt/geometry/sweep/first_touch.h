/** @file
 * When a ball on a straight way first touches a convex set of which only the nearest point is known.
 *
 * The distance to a convex set is a convex function of the way, so Newton's steps from outside never go past its first
 * zero: they come to it from before, doubling the digits (or, where the way only grazes, two bits a step). No step
 * size, no epsilon but rounding.
 */
#pragma once

#include <algorithm>

#include "rt/geometry/sweep/sweep.h"

namespace hapticd {

/** What rounding makes of a sweep's coordinates [m]. */
[[nodiscard]] inline double roundingOf(const Sweep& sweep) HD_RT {
  const double far = std::max(sweep.a.cwiseAbs().maxCoeff(), (sweep.a + sweep.d).cwiseAbs().maxCoeff());
  return 0x1p-49 * (far + sweep.radius);
}

/**
 * First t in [t, t_max] at which the ball touches the set; `foot(x)` is the point of the set nearest to x. The ball
 * must not touch it before the t given. The answer does not depend on t_max, as long as it is not beyond; by rounding
 * it may be, and the caller compares. False if there is none, or the ball overlaps the set at t by more than the
 * tolerance. `out`: unit, from the contact to the centre.
 */
template <class Foot>
[[nodiscard]] bool firstTouch(const Sweep& sweep, double rounding, double t_max, Foot&& foot, double& t,
                              Vec3& out) HD_RT {
  constexpr int kMaxSteps = 64;  // Grazing ways need half as many.
  for (int step = 0; step < kMaxSteps; ++step) {
    const Vec3 away = sweep.a + t * sweep.d - foot(Vec3(sweep.a + t * sweep.d));
    const double distance = away.norm();
    const double gap = distance - sweep.radius;
    if (distance == 0 || (step == 0 && gap < -std::max(sweep.tolerance, rounding))) return false;
    out = away / distance;
    const double slope = out.dot(sweep.d);
    if (slope >= 0) return false;
    if (gap <= rounding) return true;
    const double next = t - gap / slope;
    if (t - (gap - rounding) / slope > t_max) return false;  // But for rounding.
    if (next <= t) return true;
    t = next;
  }
  return true;
}

}  // namespace hapticd
