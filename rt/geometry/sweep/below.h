/** @file
 * What a swept ball passes high above needs no closer look: the cheapest of the separating axes, tried first.
 */
#pragma once

#include <algorithm>
#include <limits>

#include "rt/geometry/sweep/sweep.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** Triangles that lie below all of a sweep's way, seen along Sweep::above, by more than its tolerance. Servo-safe. */
class BelowWay {
 public:
  explicit BelowWay(const Sweep& sweep) noexcept : up_(sweep.above) {
    if (up_.isZero(0)) return;
    const double from = up_.dot(sweep.a);
    low_ = from + std::min(up_.dot(sweep.d), 0.0) - sweep.radius - sweep.tolerance;
  }
  /** Without a branch to be guessed: of the triangles about a ball some are, some are not. */
  [[nodiscard]] bool has(const MeshView::Corners& corners) const HD_RT {
    const bool a = heightOf(corners[0]) < low_, b = heightOf(corners[1]) < low_, c = heightOf(corners[2]) < low_;
    return static_cast<int>(a) + static_cast<int>(b) + static_cast<int>(c) == 3;
  }

 private:
  [[nodiscard]] double heightOf(const MeshView::Float3& x) const HD_RT {
    return (up_[0] * x[0] + up_[1] * x[1]) + up_[2] * x[2];
  }

  Vec3 up_;
  double low_ = -std::numeric_limits<double>::infinity();  ///< Of the ball, along the axis [m].
};

}  // namespace hapticd
