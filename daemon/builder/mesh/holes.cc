// Where a surface is open, for who wonders why a hand fell in.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "daemon/builder/mesh/mesh.h"

namespace hapticd {
namespace {

/** An edge, its ends in rising order, and where it came from. */
struct Edge {
  std::uint32_t low, high;
  std::uint32_t source_triangle;

  [[nodiscard]] bool isSame(const Edge& other) const { return low == other.low && high == other.high; }
};

/** Edges of one triangle; not those that count as open because three triangles meet there. */
std::vector<Edge> openEdges(const Mesh& mesh) {
  std::vector<Edge> edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int e = 0; e < 3; ++e) {
      if (mesh.neighbours[t][e] != HD_NO_INDEX) continue;
      const auto [low, high] = std::minmax(mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]);
      edges.push_back({low, high, mesh.source_triangle[t]});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  std::vector<Edge> open;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool alone =
        (i == 0 || !edges[i].isSame(edges[i - 1])) && (i + 1 == edges.size() || !edges[i].isSame(edges[i + 1]));
    if (alone) open.push_back(edges[i]);
  }
  return open;
}

/** What open edges that follow each other go round. */
struct Hole {
  Float3 lower, upper;
  std::uint32_t first = HD_NO_INDEX;  ///< Triangle of the upload.

  explicit Hole(const Float3& at) : lower(at), upper(at) {}
  void add(const Float3& at) {
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], at[k]);
      upper[k] = std::max(upper[k], at[k]);
    }
  }
  [[nodiscard]] double across() const {
    return std::hypot(double{upper[0]} - lower[0], double{upper[1]} - lower[1], double{upper[2]} - lower[2]);
  }
};

std::vector<Hole> holesOf(const Mesh& mesh, const std::vector<Edge>& open) {
  std::vector<std::uint32_t> group(mesh.vertices.size());
  std::iota(group.begin(), group.end(), 0u);
  const auto groupOf = [&group](std::uint32_t v) {
    while (group[v] != v) v = group[v] = group[group[v]];
    return v;
  };
  for (const Edge& edge : open) group[groupOf(edge.high)] = groupOf(edge.low);
  std::vector<std::uint32_t> place(mesh.vertices.size(), HD_NO_INDEX);
  std::vector<Hole> holes;
  for (const Edge& edge : open) {
    std::uint32_t& at = place[groupOf(edge.low)];
    if (at == HD_NO_INDEX) {
      at = static_cast<std::uint32_t>(holes.size());
      holes.emplace_back(mesh.vertices[edge.low]);
    }
    holes[at].add(mesh.vertices[edge.low]);
    holes[at].add(mesh.vertices[edge.high]);
    holes[at].first = std::min(holes[at].first, edge.source_triangle);
  }
  return holes;
}

}  // namespace

void noteHoles(const Mesh& mesh, BuildMonitor& monitor) {
  if (mesh.closed) return;
  const std::vector<Edge> open = openEdges(mesh);
  if (open.empty()) return;
  const std::vector<Hole> holes = holesOf(mesh, open);
  const Hole& widest = *std::max_element(holes.begin(), holes.end(),
                                         [](const Hole& a, const Hole& b) { return a.across() < b.across(); });
  monitor.notes.push_back(
      holes.size() == 1
          ? fmt::format("open along {} edges: one hole or rim, {:.3g} mm across, the first of triangle {}", open.size(),
                        1e3 * widest.across(), widest.first)
          : fmt::format("open along {} edges: {} holes or rims, the widest {:.3g} mm across, the first of triangle {}",
                        open.size(), holes.size(), 1e3 * widest.across(), widest.first));
}

}  // namespace hapticd
