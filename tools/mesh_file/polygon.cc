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

class EarCutter {
 public:
  explicit EarCutter(std::vector<Point> corners) : p_(std::move(corners)) {
    const auto count = static_cast<std::uint32_t>(p_.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      next_.push_back((i + 1) % count);
      before_.push_back((i + count - 1) % count);
    }
    noteDoubled();
    is_inner_.assign(count, false);
    for (std::uint32_t i = 0; i < count; ++i)
      if (mayBeInner(i)) add(i);
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
  [[nodiscard]] std::uint32_t firstAt() const { return p_.size() == 4 && !inner_.empty() ? next_[inner_.front()] : 1; }
  [[nodiscard]] bool isConvex(std::uint32_t i) const { return turn(p_[before_[i]], p_[i], p_[next_[i]]) > 0; }

  [[nodiscard]] bool isEar(std::uint32_t i) const {
    if (!isConvex(i)) return false;
    const std::array<std::uint32_t, 3> ear{before_[i], i, next_[i]};
    for (const std::uint32_t other : inner_)
      if (other != ear[0] && other != ear[1] && other != ear[2] && blocks(ear, other)) return false;
    return true;
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
  void add(std::uint32_t i) {
    inner_.push_back(i);
    is_inner_[i] = true;
  }

  /** A corner has gone, from between a and b. */
  void note(std::uint32_t gone, std::uint32_t a, std::uint32_t b) {
    for (const std::uint32_t i : {a, b})  // Of what crosses itself: else corners grow but sharper.
      if (!is_inner_[i] && mayBeInner(i)) add(i);
    if (!is_inner_[gone] && !is_inner_[a] && !is_inner_[b]) return;
    std::erase_if(inner_, [this](std::uint32_t i) {
      is_inner_[i] = mayBeInner(i);
      return !is_inner_[i];
    });
  }

  void noteDoubled() {
    std::vector<std::uint32_t> order(p_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [this](std::uint32_t i, std::uint32_t k) { return p_[i] < p_[k]; });
    doubled_.assign(p_.size(), false);
    for (std::size_t i = 1; i < order.size(); ++i)
      if (p_[order[i]] == p_[order[i - 1]]) doubled_[order[i]] = doubled_[order[i - 1]] = true;
  }

  std::vector<Point> p_;
  std::vector<std::uint32_t> next_, before_;
  std::vector<bool> doubled_;         ///< Another corner is in its place.
  std::vector<std::uint32_t> inner_;  ///< Corners that may be in an ear: what is convex is only if another one is.
  std::vector<bool> is_inner_;        ///< Whether it is one of these.
};

}  // namespace

std::vector<std::array<std::uint32_t, 3>> trianglesOf(const std::vector<std::array<float, 3>>& corners) {
  return EarCutter(flattened(corners)).run();
}

}  // namespace hapticd_mesh_file
