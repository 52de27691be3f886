/** @file
 * Sweeps and points as the boxes of the tree see them (boxes.h): rounded to single precision so that nothing is missed.
 */
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/geometry/sweep/sweep.h"
#include "rt/geometry/tree/boxes.h"

namespace hapticd {

/** Of a coordinate: beyond what single precision makes of it and of a difference with another one. */
inline constexpr double kBoxRounding = 0x1p-21;

/** x, not less, with room for the few roundings that box tests make of it. */
[[nodiscard]] inline float roundedUp(double x) HD_RT { return static_cast<float>(std::min(x * (1 + 0x1p-19), 1e30)); }

[[nodiscard]] inline BoxPoint boxPoint(const Vec3& x, double margin = 0) HD_RT {
  BoxPoint point;
  const double room = margin + kBoxRounding * x.cwiseAbs().maxCoeff();
  for (int i = 0; i < 3; ++i) {
    point.lower[i] = static_cast<float>(x[i] - room);
    point.upper[i] = static_cast<float>(x[i] + room);
  }
  return point;
}

/** The boxes that a swept ball may meet. */
class SweptBoxes {
 public:
  explicit SweptBoxes(const Sweep& sweep) noexcept : a_(sweep.a), d_(sweep.d), radius_(sweep.radius) {
    const double far = std::max(sweep.a.cwiseAbs().maxCoeff(), (sweep.a + sweep.d).cwiseAbs().maxCoeff());
    const double grown = radius_ + sweep.tolerance + kBoxRounding * (far + radius_);
    for (int i = 0; i < 3; ++i) {
      const double d = sweep.d[i], sign = d < 0 ? -1 : 1;
      box_.upward[i] = d < 0 ? 0 : 1;
      // A finite stand-in for 1/0 keeps 0 * inf out; its slab is then either always or never.
      box_.inverse[i] = static_cast<float>(std::abs(d) > 1e-30 ? 1 / d : sign * 1e30);
      box_.entry[i] = static_cast<float>(sweep.a[i] + sign * grown);
      box_.exit[i] = static_cast<float>(sweep.a[i] - sign * grown);
    }
    rounding_ = kBoxRounding * far;
    const double reach = radius_ + sweep.tolerance;
    squared_reach_ = roundedUp(reach * reach);
  }

  [[nodiscard]] std::uint32_t look(const BoxTests& tests, const hd_bvh_node& node, double t_max,
                                   float* key) const HD_RT {
    std::uint32_t mask = tests.enter(node, box_, roundedUp(t_max), key);
    if (radius_ > 0 && mask != 0) {
      // A grown box has corners that no ball reaches: what is farther than the radius from the way is not met.
      BoxPoint way;
      for (int i = 0; i < 3; ++i) {
        const double from = a_[i], to = a_[i] + t_max * d_[i];
        way.lower[i] = static_cast<float>(std::min(from, to) - rounding_);
        way.upper[i] = static_cast<float>(std::max(from, to) + rounding_);
      }
      float squared[HD_BVH_WIDTH];
      mask &= tests.approach(node, way, squared_reach_, squared);
    }
    return mask;
  }

 private:
  Vec3 a_, d_;
  BoxSweep box_;
  double radius_, rounding_ = 0;
  float squared_reach_ = 0;
};

}  // namespace hapticd
