// Cracks: edges that are cut by a vertex on one side only, be it by how a surface was meshed or because a triangle
// without area between the two was dropped. The triangle on the other side is cut there too.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "daemon/builder/mesh.h"

namespace hapticd {
namespace {

constexpr double kOnEdge = 1e-6;                 // Of the coordinates: what text of six digits leaves of them.
constexpr int kMaxRounds = 8;                    // In each a triangle is cut on one of its edges.
constexpr std::uint64_t kMaxWork = 300'000'000;  // Vertices held against edges: half a second.

/** Seen from a triangle inside: its edge from corner `edge` to the next. */
struct Border {
  std::uint32_t triangle, edge;
};

/** A vertex on an edge. */
struct Cut {
  double part;  ///< Of the edge, from its beginning.
  std::uint32_t vertex;
};

class Stitcher {
 public:
  Stitcher(const Mesh& mesh, double weld_m) : mesh_(mesh), weld_m_(weld_m) {
    std::vector<bool> is_end(mesh.vertices.size(), false);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        if (mesh.neighbours[t][e] != HD_NO_INDEX) continue;
        borders_.push_back({t, e});
        const auto [a, b] = ends(borders_.back());
        links_.push_back(link(a, b));
        is_end[a] = is_end[b] = true;
      }
    }
    if (borders_.empty()) return;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
      if (is_end[v]) ends_.push_back(v);
    chooseAxis();
    std::sort(ends_.begin(), ends_.end(), [&](std::uint32_t a, std::uint32_t b) { return along(a) < along(b); });
    std::sort(links_.begin(), links_.end());
  }

  [[nodiscard]] const std::vector<Border>& borders() const { return borders_; }
  /** Ran out of work: some edges were not looked at. */
  [[nodiscard]] bool gaveUp() const { return work_ > kMaxWork; }

  /** Where vertices of other borders lie on this one, in order, if such borders go along it. */
  const std::vector<Cut>& cuts(const Border& border) {
    cuts_.clear();
    const auto [a, b] = ends(border);
    const std::uint32_t opposite = mesh_.triangles[border.triangle][(border.edge + 2) % 3];
    const Float3 &p = mesh_.vertices[a], &q = mesh_.vertices[b];
    double d[3], length2 = 0, largest = 0;
    for (int k = 0; k < 3; ++k) {
      d[k] = double{q[k]} - p[k];
      length2 += d[k] * d[k];
      largest = std::max({largest, std::abs(double{p[k]}), std::abs(double{q[k]})});
    }
    const double near = std::max(weld_m_, kOnEdge * largest), end = near / std::sqrt(length2);
    const double low = std::min(along(a), along(b)) - near, high = std::max(along(a), along(b)) + near;
    auto it =
        std::lower_bound(ends_.begin(), ends_.end(), low, [&](std::uint32_t v, double x) { return along(v) < x; });
    for (; it != ends_.end() && along(*it) <= high && ++work_ <= kMaxWork; ++it) {
      if (*it == a || *it == b || *it == opposite) continue;
      const Float3& x = mesh_.vertices[*it];
      double part = 0, away2 = 0;
      for (int k = 0; k < 3; ++k) part += d[k] * (double{x[k]} - p[k]);
      part /= length2;
      if (!(part > end && part < 1 - end)) continue;
      for (int k = 0; k < 3; ++k) away2 += std::pow(double{x[k]} - p[k] - part * d[k], 2);
      if (away2 <= near * near) cuts_.push_back({part, *it});
    }
    std::sort(cuts_.begin(), cuts_.end(), [](const Cut& l, const Cut& r) { return l.part < r.part; });
    keepThoseWithBorders(a, b);
    return cuts_;
  }

 private:
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends(const Border& border) const {
    const Index3& v = mesh_.triangles[border.triangle];
    return {v[border.edge], v[(border.edge + 1) % 3]};
  }
  static std::uint64_t link(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  }
  [[nodiscard]] double along(std::uint32_t v) const { return mesh_.vertices[v][axis_]; }

  /** The longest: fewest vertices then lie beside an edge. */
  void chooseAxis() {
    double longest = -1;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto less = [&](std::uint32_t a, std::uint32_t b) { return mesh_.vertices[a][k] < mesh_.vertices[b][k]; };
      const auto [low, high] = std::minmax_element(ends_.begin(), ends_.end(), less);
      const double length = double{mesh_.vertices[*high][k]} - mesh_.vertices[*low][k];
      if (length > longest) axis_ = k;
      longest = std::max(longest, length);
    }
  }

  /** What merely touches is another's: borders must lead to a cut from an end of the edge, all along it. */
  void keepThoseWithBorders(std::uint32_t a, std::uint32_t b) {
    const auto linked = [&](std::uint32_t from, std::uint32_t to) {
      return std::binary_search(links_.begin(), links_.end(), link(from, to));
    };
    std::size_t from_a = 0, from_b = cuts_.size();
    for (; from_a < cuts_.size() && linked(a, cuts_[from_a].vertex); ++from_a) a = cuts_[from_a].vertex;
    for (; from_b > from_a && linked(b, cuts_[from_b - 1].vertex); --from_b) b = cuts_[from_b - 1].vertex;
    cuts_.erase(cuts_.begin() + static_cast<std::ptrdiff_t>(from_a),
                cuts_.begin() + static_cast<std::ptrdiff_t>(from_b));
  }

  const Mesh& mesh_;
  double weld_m_;
  std::vector<Border> borders_;
  std::vector<std::uint64_t> links_;  ///< Ends of borders, sorted.
  std::vector<std::uint32_t> ends_;   ///< Vertices of borders, along the axis.
  std::size_t axis_ = 0;
  std::vector<Cut> cuts_;
  std::uint64_t work_ = 0;
};

/** Fans the triangle out from the corner opposite to the edge. */
void cut(Mesh& mesh, const Border& border, const std::vector<Cut>& cuts) {
  const Index3 v = mesh.triangles[border.triangle];
  const std::uint32_t b = v[(border.edge + 1) % 3], c = v[(border.edge + 2) % 3];
  mesh.triangles[border.triangle] = {v[border.edge], cuts.front().vertex, c};
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    mesh.triangles.push_back({cuts[i].vertex, i + 1 < cuts.size() ? cuts[i + 1].vertex : b, c});
    mesh.source_triangle.push_back(mesh.source_triangle[border.triangle]);
  }
}

}  // namespace

void stitch(Mesh& mesh, double weld_m, BuildMonitor& monitor) {
  std::size_t count = 0;
  std::uint32_t first = HD_NO_INDEX;
  bool gave_up = false;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<std::pair<Border, std::vector<Cut>>> found;
    std::size_t room = HD_MAX_TRIANGLES - std::min<std::size_t>(HD_MAX_TRIANGLES, mesh.triangles.size());
    Stitcher stitcher(mesh, weld_m);
    for (const Border& border : stitcher.borders()) {
      if (!found.empty() && found.back().first.triangle == border.triangle) continue;  // Its turn comes.
      const std::vector<Cut>& cuts = stitcher.cuts(border);
      if (cuts.empty() || cuts.size() > room) continue;
      room -= cuts.size();
      found.emplace_back(border, cuts);
    }
    gave_up = stitcher.gaveUp();
    if (found.empty()) break;
    for (const auto& [border, cuts] : found) {
      first = std::min(first, mesh.source_triangle[border.triangle]);
      cut(mesh, border, cuts);
    }
    count += found.size();
    BuildMonitor again;
    connect(mesh, again);
  }
  if (count != 0) {
    monitor.notes.push_back(fmt::format(
        "cut {} edges at vertices that lay on them, the first of triangle {}: else they are cracks", count, first));
  }
  if (gave_up) monitor.notes.push_back("there are too many open edges to look for cracks along all of them");
}

}  // namespace hapticd
