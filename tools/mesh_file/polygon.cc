#include "tools/mesh_file/polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace hapticd_mesh_file {
namespace {

using Point = std::array<double, 2>;

/** Twice the area, positive if counter-clockwise. */
double turn(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/** Seen along the axis that its plane faces most, so that it runs counter-clockwise. */
std::vector<Point> flattened(const std::vector<std::array<float, 3>>& corners) {
  std::array<double, 3> normal{};  // Newell's.
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &p = corners[i], &q = corners[(i + 1) % corners.size()], &o = corners[0];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t u = (k + 1) % 3, v = (k + 2) % 3;
      normal[k] += (double{p[u]} - o[u]) * (double{q[v]} - o[v]) - (double{p[v]} - o[v]) * (double{q[u]} - o[u]);
    }
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  std::vector<Point> flat;
  flat.reserve(corners.size());
  for (const auto& p : corners) flat.push_back({double{p[u]}, double{p[v]}});
  return flat;
}

/** Some of the corners by place: a balanced tree of boxes over all of them, the root first. */
class CornerTree {
 public:
  explicit CornerTree(const std::vector<Point>& corners) : p_(corners), is_in_(p_.size()), order_(p_.size()) {
    while ((p_.size() >> depth_) > kMostInLeaf) ++depth_;
    nodes_.resize((std::size_t{2} << depth_) - 1);
    leaf_.resize(p_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    build(0, 0, 0, p_.size());
  }

  [[nodiscard]] bool has(std::uint32_t corner) const { return is_in_[corner]; }
  void set(std::uint32_t corner, bool in) {
    if (is_in_[corner] == in) return;
    is_in_[corner] = in;
    for (std::size_t n = leaf_[corner];; n = (n - 1) / 2) {
      in ? ++nodes_[n].count : --nodes_[n].count;
      if (n == 0) return;
    }
  }

  /** Whether `holds` is true of any of them that may lie in a counter-clockwise triangle. */
  template <class Holds>
  [[nodiscard]] bool any(const std::array<Point, 3>& triangle, const Holds& holds, std::size_t n = 0) const {
    const Node& node = nodes_[n];
    if (node.count == 0 || passesBy(node, triangle)) return false;
    if (2 * n + 1 < nodes_.size()) return any(triangle, holds, 2 * n + 1) || any(triangle, holds, 2 * n + 2);
    for (std::size_t i = node.begin; i < node.end; ++i)
      if (is_in_[order_[i]] && holds(order_[i])) return true;
    return false;
  }

 private:
  static constexpr std::size_t kMostInLeaf = 8;

  struct Node {
    Point lower, upper;
    std::size_t begin, end;   ///< Of order_.
    std::uint32_t count = 0;  ///< That are in it now.
  };

  void build(std::size_t n, std::uint32_t level, std::size_t begin, std::size_t end) {
    Node& node = nodes_[n];
    node.begin = begin;
    node.end = end;
    node.lower = node.upper = p_[order_[begin]];
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t k = 0; k < 2; ++k) {
        node.lower[k] = std::min(node.lower[k], p_[order_[i]][k]);
        node.upper[k] = std::max(node.upper[k], p_[order_[i]][k]);
      }
      leaf_[order_[i]] = n;
    }
    if (level == depth_) return;
    const std::size_t axis = node.upper[0] - node.lower[0] >= node.upper[1] - node.lower[1] ? 0 : 1;
    const std::size_t middle = (begin + end) / 2;
    const auto at = [this](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [&](std::uint32_t i, std::uint32_t k) { return p_[i][axis] < p_[k][axis]; });
    build(2 * n + 1, level + 1, begin, middle);
    build(2 * n + 2, level + 1, middle, end);
  }

  static bool passesBy(const Node& node, const std::array<Point, 3>& t) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (std::min({t[0][k], t[1][k], t[2][k]}) > node.upper[k]) return true;
      if (std::max({t[0][k], t[1][k], t[2][k]}) < node.lower[k]) return true;
    }
    for (std::size_t c = 0; c < 3; ++c) {  // Of an edge the corner of the box that is farthest to its left.
      const Point &a = t[c], &b = t[(c + 1) % 3];
      const Point left{b[1] > a[1] ? node.lower[0] : node.upper[0], b[0] > a[0] ? node.upper[1] : node.lower[1]};
      if (turn(a, b, left) < 0) return true;
    }
    return false;
  }

  const std::vector<Point>& p_;
  std::vector<bool> is_in_;
  std::vector<std::uint32_t> order_;
  std::vector<std::size_t> leaf_;  ///< Of each corner.
  std::vector<Node> nodes_;
  std::uint32_t depth_ = 0;
};

class EarCutter {
 public:
  explicit EarCutter(std::vector<Point> corners) : p_(std::move(corners)), inner_(p_) {
    const auto count = static_cast<std::uint32_t>(p_.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      next_.push_back((i + 1) % count);
      before_.push_back((i + count - 1) % count);
    }
    noteDoubled();
    for (std::uint32_t i = 0; i < count; ++i) inner_.set(i, mayBeInner(i));
  }

  std::vector<std::array<std::uint32_t, 3>> run() {
    std::vector<std::array<std::uint32_t, 3>> out;
    auto left = static_cast<std::uint32_t>(p_.size());
    out.reserve(left - 2);
    // From where the last ear was, round the whole of it at most: first for true ears, then for what sticks out, then
    // for anything.
    for (std::uint32_t at = firstAt(), tried = 0, lax = 0; left >= 3;) {
      if (left > 3 && !(lax == 0 ? isEar(at) : lax == 2 || isConvex(at))) {
        at = next_[at];
        if (++tried == left) ++lax, tried = 0;
        continue;
      }
      const std::uint32_t a = before_[at], b = next_[at];
      out.push_back({a, at, b});
      next_[a] = b;
      before_[b] = a;
      before_[at] = next_[at] = at;  // Gone.
      --left;
      note(at, a, b);
      at = next_[b];  // Not beside it: else fans of needles.
      tried = lax = 0;
    }
    return out;
  }

 private:
  /** Of four corners the one beside a blunt one, so that the cut ends there. */
  [[nodiscard]] std::uint32_t firstAt() const {
    if (p_.size() != 4) return 1;
    for (std::uint32_t i = 0; i < 4; ++i)
      if (inner_.has(i)) return next_[i];
    return 1;
  }
  [[nodiscard]] bool isConvex(std::uint32_t i) const { return turn(p_[before_[i]], p_[i], p_[next_[i]]) > 0; }

  [[nodiscard]] bool isEar(std::uint32_t i) const {
    if (!isConvex(i)) return false;
    const std::array<std::uint32_t, 3> ear{before_[i], i, next_[i]};
    return !inner_.any({p_[ear[0]], p_[ear[1]], p_[ear[2]]}, [&](std::uint32_t other) {
      return other != ear[0] && other != ear[1] && other != ear[2] && blocks(ear, other);
    });
  }

  [[nodiscard]] bool blocks(const std::array<std::uint32_t, 3>& ear, std::uint32_t other) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (turn(p_[ear[k]], p_[ear[(k + 1) % 3]], p_[other]) < 0) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point &a = p_[ear[k]], &b = p_[ear[(k + 1) % 3]], &c = p_[ear[(k + 2) % 3]];
      if (p_[other] == a) return leadsBetween(a, b, c, p_[next_[other]]) || leadsBetween(a, b, c, p_[before_[other]]);
    }
    return true;
  }
  /** The edge from a to x, of a corner in the same place as a. */
  static bool leadsBetween(const Point& a, const Point& b, const Point& c, const Point& x) {
    return turn(a, b, x) > 0 && turn(a, x, c) > 0;
  }

  [[nodiscard]] bool mayBeInner(std::uint32_t i) const { return next_[i] != i && (doubled_[i] || !isConvex(i)); }

  /** A corner has gone, from between a and b. */
  void note(std::uint32_t gone, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t i : {gone, a, b}) inner_.set(i, mayBeInner(i));
  }

  void noteDoubled() {
    std::vector<std::uint32_t> order(p_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [this](std::uint32_t i, std::uint32_t k) { return p_[i] < p_[k]; });
    doubled_.assign(p_.size(), false);
    for (std::size_t i = 1; i < order.size(); ++i)
      if (p_[order[i]] == p_[order[i - 1]]) doubled_[order[i]] = doubled_[order[i - 1]] = true;
  }

  const std::vector<Point> p_;
  std::vector<std::uint32_t> next_, before_;
  std::vector<bool> doubled_;  ///< Another corner is in its place.
  CornerTree inner_;           ///< Corners that may be in an ear: what is convex is only if another one is.
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> trianglesOf(const std::vector<std::array<float, 3>>& corners) {
  return EarCutter(flattened(corners)).run();
}

}  // namespace hapticd_mesh_file
