/** @file
 * When the swept ball may first touch something in a box of the tree: never later than it does.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/geometry/sweep.h"
#include "rt/geometry/tree_walk.h"

namespace hapticd {

class SweptBox {
 public:
  explicit SweptBox(const Sweep& sweep) noexcept : a_(sweep.a), d_(sweep.d), radius_(sweep.radius) {
    // A line may meet a triangle at a corner of its box: rounding must not part them.
    const double scale = std::max(sweep.a.cwiseAbs().maxCoeff(), (sweep.a + sweep.d).cwiseAbs().maxCoeff());
    margin_ = std::max(sweep.tolerance, 0x1p-48 * (scale + radius_));
    length_ = radius_ > 0 ? sweep.d.norm() : 0.0;
    for (int i = 0; i < 3; ++i) {
      // A finite stand-in for 1/0 keeps 0 * inf out; its slab is then either always or never.
      inverse_[i] = std::abs(sweep.d[i]) > 1e-280 ? 1.0 / sweep.d[i] : (sweep.d[i] < 0 ? -1e280 : 1e280);
    }
  }

  /** Slab test against the grown box; infinity if not before t_max. */
  [[nodiscard]] double enter(const hd_bvh_node& node, double t_max) const HD_RT {
    double in = 0, out = t_max;
    const double grown = radius_ + margin_;
    for (int i = 0; i < 3; ++i) {
      const double t0 = (double{node.lower[i]} - grown - a_[i]) * inverse_[i];
      const double t1 = (double{node.upper[i]} + grown - a_[i]) * inverse_[i];
      in = std::max(in, std::min(t0, t1));
      out = std::min(out, std::max(t0, t1));
    }
    if (!(in <= out) || (radius_ > 0 && isFar(node, t_max))) return std::numeric_limits<double>::infinity();
    return in;
  }

 private:
  /** Beyond a ball about the whole way: a grown box has corners that no ball reaches. */
  [[nodiscard]] bool isFar(const hd_bvh_node& node, double t_max) const HD_RT {
    const double reach = radius_ + margin_ + 0.5 * t_max * length_;
    return squaredDistance(node, a_ + 0.5 * t_max * d_) > reach * reach;
  }

  Vec3 a_, d_, inverse_;
  double radius_, margin_ = 0, length_ = 0;
};

}  // namespace hapticd
