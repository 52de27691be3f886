/** @file
 * A triangle mesh that a program keeps for itself, and the points of it nearest to a tool. Needs no daemon.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <hapticclient/result.hpp>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace haptic {

/** x, y, z in the mesh's frame [m]; also a direction. */
using Vector = std::array<double, 3>;

namespace detail {

inline Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector operator*(double s, const Vector& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }

/** Point of triangle a, b, c nearest to x, by the regions of its plane (Ericson, Real-Time Collision Detection, 5.1.5).
 */
inline Vector nearestOnTriangle(const Vector& a, const Vector& b, const Vector& c, const Vector& x) {
  const Vector ab = b - a, ac = c - a, ax = x - a, bx = x - b, cx = x - c;
  const double d1 = dot(ab, ax), d2 = dot(ac, ax);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = dot(ab, bx), d4 = dot(ac, bx);
  if (d3 >= 0 && d4 <= d3) return b;
  const double of_c = d1 * d4 - d3 * d2;
  if (of_c <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = dot(ab, cx), d6 = dot(ac, cx);
  if (d6 >= 0 && d5 <= d6) return c;
  const double of_b = d5 * d2 - d1 * d6;
  if (of_b <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double of_a = d3 * d6 - d5 * d4;
  if (of_a <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double sum = of_a + of_b + of_c;
  return a + of_b / sum * ab + of_c / sum * ac;
}

}  // namespace detail

/** Built once, in about 0.5 us a triangle; then read by any number of threads. */
class SurfaceMesh {
 public:
  /** The point nearest to a query. */
  struct Foot {
    Vector point{};
    Vector normal{};             ///< Of the triangle there: unit, outward.
    std::uint32_t triangle = 0;  ///< As handed in.
    double distance = std::numeric_limits<double>::infinity();
  };

  /**
   * From x, y, z per vertex [m] and three indices per triangle, counter-clockwise seen from outside; copied. Triangles
   * without area are left out. HAPTIC_INVALID_ARGUMENT names the first coordinate that is not finite, index that is out
   * of range, or vertex or triangle that is not whole.
   */
  [[nodiscard]] static Result<SurfaceMesh> make(std::span<const float> vertices,
                                                std::span<const std::uint32_t> triangles) {
    const auto refuse = [](const char* part, std::size_t which, const char* what, const char* remedy) {
      std::string where = part;
      where += std::to_string(which);  // (one sum of both makes g++ 12 warn of what is not there)
      return Error{HAPTIC_INVALID_ARGUMENT, std::move(where), what, remedy};
    };
    if (vertices.size() % 3 != 0) return refuse("vertex ", vertices.size() / 3, "is not whole", "give x, y and z");
    if (triangles.size() % 3 != 0)
      return refuse("triangle ", triangles.size() / 3, "is not whole", "give three indices each");
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (!std::isfinite(vertices[i])) return refuse("vertex ", i / 3, "is not finite", "check how it was computed");
    }
    SurfaceMesh mesh;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (triangles[i] >= vertices.size() / 3) return refuse("triangle ", i / 3, "names no vertex", "count from 0");
    }
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        const float* p = &vertices[3 * std::size_t{triangles[t + k]}];
        triangle.corner[k] = {p[0], p[1], p[2]};
      }
      using namespace detail;  // NOLINT(google-build-using-namespace)
      const auto& [a, b, c] = triangle.corner;
      const Vector n = cross(b - a, c - a);
      const double area = length(n);
      if (!(area > 0)) continue;
      triangle.normal = 1 / area * n;
      triangle.index = static_cast<std::uint32_t>(t / 3);
      mesh.triangles_.push_back(triangle);
    }
    if (mesh.triangles_.empty()) return refuse("mesh of triangles: ", 0, "none has an area", "check the units");
    mesh.nodes_.reserve(2 * mesh.triangles_.size() / kLeaf + 2);
    mesh.build(0, mesh.triangles_.size());
    return mesh;
  }

  /** The nearest point. Of triangles that share it, the one that faces x most: so the sign of `above` is right. */
  [[nodiscard]] Foot nearest(const Vector& x) const {
    using namespace detail;  // NOLINT(google-build-using-namespace)
    Foot best;
    double facing = 0;
    std::array<std::uint32_t, 64> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (distanceTo(node, x) > best.distance * (1 + kTie)) continue;
      if (node.count == 0) {
        std::uint32_t near = static_cast<std::uint32_t>(&node - nodes_.data()) + 1, far = node.first;
        if (distanceTo(nodes_[far], x) < distanceTo(nodes_[near], x)) std::swap(near, far);
        stack[top++] = far;
        stack[top++] = near;
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Triangle& t = triangles_[i];
        const Vector p = nearestOnTriangle(t.corner[0], t.corner[1], t.corner[2], x);
        const double distance = length(x - p), faces = std::abs(dot(t.normal, x - p));
        const bool tie = std::abs(distance - best.distance) <= kTie * distance;
        if (tie ? faces <= facing : distance > best.distance) continue;
        best = {p, t.normal, t.index, distance};
        facing = faces;
      }
    }
    return best;
  }

  /** Height of x above its foot: negative behind the surface [m]. */
  [[nodiscard]] static double above(const Foot& foot, const Vector& x) {
    using namespace detail;  // NOLINT(google-build-using-namespace)
    return std::copysign(foot.distance, dot(foot.normal, x - foot.point));
  }

  [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }

 private:
  SurfaceMesh() = default;

  static constexpr std::size_t kLeaf = 4;
  static constexpr double kTie = 1e-9;  ///< Relative difference of two distances that are the same.

  struct Triangle {
    std::array<Vector, 3> corner{};
    Vector normal{};
    std::uint32_t index = 0;
  };
  /** A box with its triangles, or with two nodes: the next one and `first`. */
  struct Node {
    Vector low{}, high{};
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< Triangles; 0: inner node.
  };

  static double distanceTo(const Node& node, const Vector& x) {
    double squared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double out = std::max({node.low[k] - x[k], 0.0, x[k] - node.high[k]});
      squared += out * out;
    }
    return std::sqrt(squared);
  }

  void build(std::size_t first, std::size_t last) {
    const std::size_t at = nodes_.size();
    nodes_.emplace_back();
    Node node;
    node.low.fill(std::numeric_limits<double>::infinity());
    node.high.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t i = first; i < last; ++i) {
      for (const Vector& corner : triangles_[i].corner) {
        for (std::size_t k = 0; k < 3; ++k) {
          node.low[k] = std::min(node.low[k], corner[k]);
          node.high[k] = std::max(node.high[k], corner[k]);
        }
      }
    }
    if (last - first <= kLeaf) {
      node.first = static_cast<std::uint32_t>(first);
      node.count = static_cast<std::uint32_t>(last - first);
    } else {
      std::size_t axis = 0;
      for (std::size_t k = 1; k < 3; ++k) {
        if (node.high[k] - node.low[k] > node.high[axis] - node.low[axis]) axis = k;
      }
      const std::size_t middle = first + (last - first) / 2;
      const auto begin = triangles_.begin();
      const auto centre = [axis](const Triangle& t) {
        return t.corner[0][axis] + t.corner[1][axis] + t.corner[2][axis];
      };
      std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                       begin + static_cast<std::ptrdiff_t>(last),
                       [&](const Triangle& a, const Triangle& b) { return centre(a) < centre(b); });
      build(first, middle);
      node.first = static_cast<std::uint32_t>(nodes_.size());
      build(middle, last);
    }
    nodes_[at] = node;
  }

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace haptic
