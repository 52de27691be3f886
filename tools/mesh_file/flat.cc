#include "tools/mesh_file/flat.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <queue>
#include <unordered_map>
#include <utility>

namespace hapticd_mesh_file {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr double kFlat = 1e-7;    ///< Height of a flat triangle over its longest side.
constexpr double kNeedle = 1e-6;  ///< Shortest side of a flat one whose corners become one.

/** Of a triangle; sides are numbered by the corner they begin at. */
struct Sides {
  int longest = 0, shortest = 0;
  double longest_m = 0, shortest_m = 0;
  bool flat = false, needle = false;
};

Sides sidesOf(const std::vector<Vertex>& vertices, const Triangle& v) {
  Sides s;
  Vec3 x[3];
  for (std::size_t c = 0; c < 3; ++c) x[c] = Vec3(vertices[v[c]][0], vertices[v[c]][1], vertices[v[c]][2]);
  for (int c = 0; c < 3; ++c) {
    const double length = (x[(c + 1) % 3] - x[c]).norm();
    if (c == 0 || length > s.longest_m) s.longest = c, s.longest_m = length;
    if (c == 0 || length < s.shortest_m) s.shortest = c, s.shortest_m = length;
  }
  s.flat = (x[1] - x[0]).cross(x[2] - x[0]).norm() <= kFlat * s.longest_m * s.longest_m;
  s.needle = s.flat && s.shortest_m <= kNeedle * s.longest_m;
  return s;
}

class Mender {
 public:
  Mender(const std::vector<Vertex>& vertices, std::vector<Triangle> triangles)
      : vertices_(vertices), triangles_(std::move(triangles)), flips_left_(64 * triangles_.size()) {}

  std::vector<Triangle> mend() {
    for (bool any = true; any;) {  // A flip may leave a needle, and what has collapsed a cap.
      any = collapse();
      any = flip() || any;
    }
    return std::move(triangles_);
  }

 private:
  using Edge = std::uint64_t;  ///< Directed, counter-clockwise about its triangle.
  static Edge edge(std::uint32_t from, std::uint32_t to) { return Edge{from} << 32 | to; }
  static std::size_t corner(int c) { return static_cast<std::size_t>(c % 3); }
  static bool gone(const Triangle& v) { return v[0] == v[1] || v[1] == v[2] || v[2] == v[0]; }
  [[nodiscard]] Sides sidesOf(std::uint32_t t) const { return hapticd_mesh_file::sidesOf(vertices_, triangles_[t]); }

  /** What is left of triangles goes. Whether there was any. */
  bool sweep() { return std::erase_if(triangles_, gone) > 0; }

  /** The ends of short sides of flat triangles become one. */
  bool collapse() {
    std::vector<std::uint32_t> root(vertices_.size());
    std::iota(root.begin(), root.end(), 0U);
    const auto find = [&root](std::uint32_t v) {
      while (root[v] != v) v = root[v] = root[root[v]];
      return v;
    };
    for (const auto& v : triangles_) {
      const Sides s = hapticd_mesh_file::sidesOf(vertices_, v);
      if (!s.needle) continue;
      const std::uint32_t a = find(v[corner(s.shortest)]), b = find(v[corner(s.shortest + 1)]);
      root[std::max(a, b)] = std::min(a, b);
    }
    for (auto& v : triangles_) v = {find(v[0]), find(v[1]), find(v[2])};
    return sweep();
  }

  /** The middle corner of each flat triangle becomes one of the triangle beyond its longest side, too. */
  bool flip() {
    std::priority_queue<std::pair<double, std::uint32_t>> flat;  // The longest first: what lies beyond is no longer.
    const auto look = [&](std::uint32_t t) {
      if (const Sides s = sidesOf(t); s.flat && !s.needle) flat.emplace(s.longest_m, t);
    };
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) look(t);
    if (flat.empty()) return false;
    owner_.clear();
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) own(t);
    bool any = false;
    for (; !flat.empty() && flips_left_ > 0; --flips_left_) {
      const auto [length, t] = flat.top();
      flat.pop();
      const Sides s = sidesOf(t);
      if (gone(triangles_[t]) || !s.flat || s.needle || s.longest_m != length) continue;  // Mended meanwhile.
      const auto beyond = owner_.find(edge(triangles_[t][corner(s.longest + 1)], triangles_[t][corner(s.longest)]));
      const std::uint32_t other = beyond == owner_.end() ? t : beyond->second;
      if (!flip(t, s.longest, other)) continue;
      any = true;
      for (const std::uint32_t changed : {t, other})
        if (!gone(triangles_[changed])) look(changed);
    }
    sweep();
    return any;
  }

  /** Triangle a b m, whose m lies on a b, and b a d beyond become b m d and m a d. */
  bool flip(std::uint32_t t, int longest, std::uint32_t beyond) {
    const auto v = triangles_[t];
    const std::uint32_t a = v[corner(longest)], b = v[corner(longest + 1)], m = v[corner(longest + 2)];
    if (beyond == t) {  // A border: its other two sides are the border then.
      disown(t);
      triangles_[t] = {a, a, a};
      return true;
    }
    const auto w = triangles_[beyond];
    const std::uint32_t d = w[0] != a && w[0] != b ? w[0] : w[1] != a && w[1] != b ? w[1] : w[2];
    if (d != m && (owner_.count(edge(m, d)) != 0 || owner_.count(edge(d, m)) != 0)) return false;
    disown(t);
    disown(beyond);
    triangles_[t] = {m, a, d};
    triangles_[beyond] = {b, m, d};
    if (d == m) return true;  // Back to back: both are gone.
    own(t);
    own(beyond);
    return true;
  }

  void own(std::uint32_t t) {
    const auto& v = triangles_[t];
    for (int c = 0; c < 3; ++c) owner_[edge(v[corner(c)], v[corner(c + 1)])] = t;
  }
  void disown(std::uint32_t t) {
    const auto& v = triangles_[t];
    for (int c = 0; c < 3; ++c) {
      const auto it = owner_.find(edge(v[corner(c)], v[corner(c + 1)]));
      if (it != owner_.end() && it->second == t) owner_.erase(it);
    }
  }

  const std::vector<Vertex>& vertices_;
  std::vector<Triangle> triangles_;
  std::size_t flips_left_;  ///< Each makes a longest side shorter; where surfaces cross, nothing promises that.
  std::unordered_map<Edge, std::uint32_t> owner_;
};

}  // namespace

bool isFlat(const std::vector<Vertex>& vertices, const Triangle& triangle) { return sidesOf(vertices, triangle).flat; }

std::vector<Triangle> withoutFlatTriangles(const std::vector<Vertex>& vertices, std::vector<Triangle> triangles) {
  return Mender(vertices, std::move(triangles)).mend();
}

}  // namespace hapticd_mesh_file
