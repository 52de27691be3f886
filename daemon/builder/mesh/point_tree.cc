#include "daemon/builder/mesh/point_tree.h"

namespace hapticd {

PointTree::PointTree(const std::vector<Float3>& vertices, const std::vector<std::uint32_t>& numbers) {
  if (numbers.empty()) return;
  points_.reserve(numbers.size());
  Float3 lower = vertices[numbers.front()], upper = lower;
  for (const std::uint32_t number : numbers) {
    const Float3& at = vertices[number];
    points_.push_back({at, number});
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], at[k]);
      upper[k] = std::max(upper[k], at[k]);
    }
  }
  halves_.resize(points_.size());
  build(0, points_.size(), lower, upper);
}

void PointTree::build(std::size_t begin, std::size_t end, Float3 lower, Float3 upper) {
  while (end - begin > kLeaf) {
    std::size_t k = 0;
    for (std::size_t i = 1; i < 3; ++i) {
      if (double{upper[i]} - lower[i] > double{upper[k]} - lower[k]) k = i;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) { return points_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [k](const Point& a, const Point& b) { return a.at[k] < b.at[k]; });
    const float split = points_[middle].at[k];
    halves_[middle] = {static_cast<std::uint32_t>(k), split};
    Float3 to = upper;
    to[k] = split;
    build(begin, middle, lower, to);
    lower[k] = split;
    begin = middle;
  }
}

}  // namespace hapticd
