#include "tools/hapticctl-cut/sound_surface.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <unordered_map>

namespace hapticctl_cut {
namespace {

using Vec3 = Eigen::Vector3d;
using Triangle = std::array<std::uint32_t, 3>;

bool hasCornerTwice(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/** The triangles of a mesh, found by an edge in its direction. */
class Edges {
 public:
  explicit Edges(const std::vector<Triangle>& triangles) {
    owner_.reserve(3 * triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) add(triangles[i], i);
  }
  void add(const Triangle& t, std::size_t number) {
    for (std::size_t c = 0; c < 3; ++c) owner_.emplace(key(t[c], t[(c + 1) % 3]), number);
  }
  void remove(const Triangle& t, std::size_t number) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [first, end] = owner_.equal_range(key(t[c], t[(c + 1) % 3]));
      const auto mine = std::find_if(first, end, [&](const auto& entry) { return entry.second == number; });
      if (mine != end) owner_.erase(mine);
    }
  }
  /** The only one with the edge from a to b. */
  [[nodiscard]] std::optional<std::size_t> only(std::uint32_t a, std::uint32_t b) const {
    const auto [first, end] = owner_.equal_range(key(a, b));
    if (first == end || std::next(first) != end) return std::nullopt;
    return first->second;
  }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) { return static_cast<std::uint64_t>(a) << 32 | b; }
  std::unordered_multimap<std::uint64_t, std::size_t> owner_;
};

/** The corner opposite the longest edge, where all three lie on one line. */
std::optional<std::size_t> middleOf(const Surface& mesh, const Triangle& t) {
  Vec3 p[3];
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& v = mesh.vertices[t[c]];
    p[c] = Vec3(v[0], v[1], v[2]);
  }
  if ((p[1] - p[0]).cross(p[2] - p[0]).squaredNorm() > 0) return std::nullopt;
  std::size_t middle = 0;
  double longest = -1;
  for (std::size_t c = 0; c < 3; ++c) {
    const double edge = (p[(c + 2) % 3] - p[(c + 1) % 3]).squaredNorm();
    if (edge > longest) longest = edge, middle = c;
  }
  return middle;
}

}  // namespace

Surface withoutNeedles(Surface mesh) {
  auto& triangles = mesh.triangles;
  std::vector<std::size_t> needles;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (middleOf(mesh, triangles[i])) needles.push_back(i);
  if (needles.empty()) return mesh;

  Edges edges(triangles);
  // Needles that lie across one another may hand on more of them, each shorter than the one it comes of.
  for (std::size_t turns = 0; turns < needles.size() && turns < 16 * triangles.size(); ++turns) {
    const std::size_t i = needles[turns];
    const Triangle needle = triangles[i];
    const auto middle = middleOf(mesh, needle);
    if (!middle || hasCornerTwice(needle)) continue;
    const std::uint32_t m = needle[*middle], a = needle[(*middle + 1) % 3], b = needle[(*middle + 2) % 3];
    const auto across = edges.only(b, a);
    if (!across || !edges.only(a, b)) continue;
    const Triangle wide = triangles[*across];
    const std::uint32_t c = wide[0] != a && wide[0] != b ? wide[0] : wide[1] != a && wide[1] != b ? wide[1] : wide[2];
    edges.remove(needle, i);
    edges.remove(wide, *across);
    triangles[i] = {m, a, c};
    triangles[*across] = {m, c, b};
    for (const std::size_t k : {i, *across}) {
      edges.add(triangles[k], k);
      if (middleOf(mesh, triangles[k]) && !hasCornerTwice(triangles[k])) needles.push_back(k);
    }
  }
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(), hasCornerTwice), triangles.end());
  return mesh;
}

}  // namespace hapticctl_cut
