/** @file
 * Points in a tree of halves, to find those near a straight line between two of them.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "daemon/builder/mesh/mesh.h"

namespace hapticd {

/** From `p` to `p + d`, as thick as `near` to each side [m]. */
struct ThickLine {
  std::array<double, 3> p, d;
  double near;
};

/** Halves of halves, each across the axis along which it is longest. */
class PointTree {
 public:
  PointTree() = default;
  /** Those of `vertices` with these numbers. */
  PointTree(const std::vector<Float3>& vertices, const std::vector<std::uint32_t>& numbers);

  /**
   * Calls found(number, point) for each point that may be within the line, and for some beside it. Takes from `work`
   * one for each half and each point that is looked at; without any left it returns.
   */
  template <class Found>
  void near(const ThickLine& line, std::int64_t& work, Found&& found) const {
    if (!points_.empty()) look(line, 0, points_.size(), 0, 1, work, found);
  }

 private:
  struct Point {
    Float3 at;
    std::uint32_t number;
  };
  struct Half {
    std::uint32_t axis;
    float split;  ///< No point below is above it, none above below.
  };
  static constexpr std::size_t kLeaf = 8;

  void build(std::size_t begin, std::size_t end, Float3 lower, Float3 upper);

  /** Of the line the part from t0 to t1 is in the half. */
  template <class Found>
  void look(const ThickLine& line, std::size_t begin, std::size_t end, double t0, double t1, std::int64_t& work,
            Found& found) const {
    while (end - begin > kLeaf) {
      if (--work < 0) return;
      const std::size_t middle = begin + (end - begin) / 2;
      const std::size_t k = halves_[middle].axis;
      const double split = halves_[middle].split, d = line.d[k];
      const double a = line.p[k] + t0 * d, b = line.p[k] + t1 * d;
      const bool low = std::min(a, b) - line.near <= split, high = std::max(a, b) + line.near >= split;
      if (low && high) {
        double low0 = t0, low1 = t1;
        if (d > 0) {
          low1 = std::min(t1, (split + line.near - line.p[k]) / d);
          t0 = std::max(t0, (split - line.near - line.p[k]) / d);
        } else if (d < 0) {
          low0 = std::max(t0, (split + line.near - line.p[k]) / d);
          t1 = std::min(t1, (split - line.near - line.p[k]) / d);
        }
        look(line, begin, middle, low0, low1, work, found);
      }
      (high ? begin : end) = middle;
    }
    for (; begin < end && --work >= 0; ++begin) found(points_[begin].number, points_[begin].at);
  }

  std::vector<Point> points_;
  std::vector<Half> halves_;  ///< By the middle of what is cut.
};

}  // namespace hapticd
