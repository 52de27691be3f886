/** @file
 * What a swept ball passes high above needs no closer look: the cheapest of the separating axes, tried first.
 */
#pragma once

#include <algorithm>
#include <limits>

#include "rt/geometry/sweep.h"

namespace hapticd {

/** Triangles that lie below all of a sweep's way, seen along Sweep::above, by more than its tolerance. Servo-safe. */
class BelowWay {
 public:
  explicit BelowWay(const Sweep& sweep) noexcept : up_(sweep.above) {
    if (up_.isZero(0)) return;
    const double from = up_.dot(sweep.a);
    low_ = from + std::min(up_.dot(sweep.d), 0.0) - sweep.radius - sweep.tolerance;
  }
  [[nodiscard]] bool has(const Vec3& a, const Vec3& b, const Vec3& c) const HD_RT {
    return up_.dot(a) < low_ && up_.dot(b) < low_ && up_.dot(c) < low_;
  }

 private:
  Vec3 up_;
  double low_ = -std::numeric_limits<double>::infinity();  ///< Of the ball, along the axis [m].
};

}  // namespace hapticd
