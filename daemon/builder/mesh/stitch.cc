// Cracks: edges that are cut by a vertex on one side only, be it by how a surface was meshed or because a triangle
// without area between the two was dropped. The triangle on the other side is cut there too.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_set>

#include "daemon/builder/mesh/counted.h"
#include "daemon/builder/mesh/mesh.h"
#include "daemon/builder/mesh/point_tree.h"

namespace hapticd {
namespace {

// Of the coordinates: what lies so near is on an edge. First what floats leave, then what text of six digits leaves of
// a vertex and of the edge's ends; that at once would take corners for one another where something is small.
constexpr double kOnEdge[] = {1e-6, 2e-5};
constexpr double kRounding = 0x1p-22;   // Of the coordinates, as floats: four of their steps at most.
constexpr std::int64_t kKept = 32;      // Steps that a vertex on an edge counts for: it is kept.
constexpr double kSpare = 1 + 0x1p-20;  // For what rounding may leave out of the search.

/** Seen from a triangle inside: its edge from corner `edge` to the next. */
struct Border {
  std::uint32_t triangle, edge;
};

/** A vertex on an edge. */
struct EdgeVertex {
  double part;  ///< Of the edge, from its beginning.
  std::uint32_t vertex;
};

/** A border with vertices of other borders on it, in order from its beginning. */
struct Crossed {
  Border border;
  std::vector<EdgeVertex> on;
  std::size_t from_a = 0, from_b = 0;  ///< How many of them borders lead to, from either end.
};

class Stitcher {
 public:
  /** Takes what it needs from `work`. */
  Stitcher(const Mesh& mesh, double weld_m, double on_edge, std::int64_t& work)
      : mesh_(mesh), weld_m_(weld_m), on_edge_(on_edge), work_(work) {
    std::vector<Border> borders;
    std::vector<bool> is_end(mesh.vertices.size(), false);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        if (mesh.neighbours[t][e] != HD_NO_INDEX) continue;
        borders.push_back({t, e});
        const auto [a, b] = ends(borders.back());
        is_end[a] = is_end[b] = true;
      }
    }
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
      if (is_end[v]) numbers.push_back(v);
    tree_ = PointTree(mesh.vertices, numbers);
    for (const Border& border : borders) {
      std::vector<EdgeVertex> on = verticesOn(border);
      if (gaveUp()) break;
      if (!on.empty()) crossed_.push_back({border, std::move(on)});
    }
    if (crossed_.empty()) return;
    links_.reserve(2 * borders.size());
    for (const Border& border : borders) {
      const auto [a, b] = ends(border);
      links_.insert(link(a, b));
    }
    findThoseWithBorders();
  }

  /** By triangles. */
  [[nodiscard]] std::vector<Crossed>& crossed() { return crossed_; }
  /** Ran out of work: some edges were not looked at. */
  [[nodiscard]] bool gaveUp() const { return work_ < 0; }

 private:
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends(const Border& border) const {
    const Index3& v = mesh_.triangles[border.triangle];
    return {v[border.edge], v[(border.edge + 1) % 3]};
  }
  static std::uint64_t link(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  }

  std::vector<EdgeVertex> verticesOn(const Border& border) {
    std::vector<EdgeVertex> cuts;
    const std::uint32_t a = ends(border).first, b = ends(border).second;
    const std::uint32_t opposite = mesh_.triangles[border.triangle][(border.edge + 2) % 3];
    const Float3 &p = mesh_.vertices[a], &q = mesh_.vertices[b];
    ThickLine line{};
    double length2 = 0, largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      line.p[k] = double{p[k]};
      line.d[k] = double{q[k]} - p[k];
      length2 += line.d[k] * line.d[k];
      largest = std::max({largest, std::abs(double{p[k]}), std::abs(double{q[k]})});
    }
    const double near = std::max(weld_m_, on_edge_ * largest), end = kRounding * largest / std::sqrt(length2);
    line.near = kSpare * near;
    tree_.near(line, work_, [&](std::uint32_t v, const Float3& x) {
      if (v == a || v == b || v == opposite) return;
      double part = 0, away2 = 0;
      for (std::size_t k = 0; k < 3; ++k) part += line.d[k] * (double{x[k]} - p[k]);
      part /= length2;
      if (!(part > end && part < 1 - end)) return;
      for (std::size_t k = 0; k < 3; ++k) {
        const double away = double{x[k]} - p[k] - part * line.d[k];
        away2 += away * away;
      }
      if (away2 > near * near) return;
      cuts.push_back({part, v});
      work_ -= kKept;
    });
    std::sort(cuts.begin(), cuts.end(), [](const EdgeVertex& l, const EdgeVertex& r) {
      return l.part != r.part ? l.part < r.part : l.vertex < r.vertex;
    });
    return cuts;
  }

  /**
   * What merely touches is another's: borders must lead to a cut from an end of the edge, all along it. Each cut makes
   * new borders, which may lead on to cuts of the edge on the other side.
   */
  void findThoseWithBorders() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> of_vertex;  // The vertex, and whose edge it is on.
    std::vector<std::uint32_t> waiting;
    for (std::uint32_t i = 0; i < crossed_.size(); ++i) {
      waiting.push_back(i);
      for (const EdgeVertex& cut : crossed_[i].on) of_vertex.emplace_back(cut.vertex, i);
    }
    std::sort(of_vertex.begin(), of_vertex.end());
    const auto add = [&](std::uint32_t from, std::uint32_t to) {
      if (!links_.insert(link(from, to)).second) return;
      for (const std::uint32_t v : {from, to}) {
        auto it = std::lower_bound(of_vertex.begin(), of_vertex.end(), std::pair(v, std::uint32_t{0}));
        for (; it != of_vertex.end() && it->first == v && --work_ >= 0; ++it) waiting.push_back(it->second);
      }
    };
    while (!waiting.empty()) {
      Crossed& one = crossed_[waiting.back()];
      waiting.pop_back();
      const std::size_t count = one.on.size();
      const std::uint32_t a = ends(one.border).first, b = ends(one.border).second;
      const auto linked = [&](std::uint32_t from, std::uint32_t to) { return links_.count(link(from, to)) != 0; };
      const std::size_t from_a = one.from_a, from_b = one.from_b;
      const auto last = [&] { return one.from_a == 0 ? a : one.on[one.from_a - 1].vertex; };
      const auto first = [&] { return one.from_b == 0 ? b : one.on[count - one.from_b].vertex; };
      while (one.from_a + one.from_b < count && linked(last(), one.on[one.from_a].vertex)) ++one.from_a;
      while (one.from_a + one.from_b < count && linked(first(), one.on[count - one.from_b - 1].vertex)) ++one.from_b;
      // The edge goes from cut to cut now, and over what is left between those from either end.
      if (one.from_a != from_a || one.from_b != from_b) add(last(), first());
    }
    for (Crossed& one : crossed_) {
      const auto middle = one.on.begin() + static_cast<std::ptrdiff_t>(one.from_a);
      one.on.erase(middle, one.on.end() - static_cast<std::ptrdiff_t>(one.from_b));
    }
  }

  const Mesh& mesh_;
  double weld_m_, on_edge_;
  PointTree tree_;  ///< Ends of borders.
  std::vector<Crossed> crossed_;
  std::unordered_set<std::uint64_t> links_;  ///< Ends of borders, of those too that cutting makes.
  std::int64_t& work_;
};

bool isEmpty(const Index3& v) { return v[0] == v[1] || v[1] == v[2] || v[2] == v[0]; }

/** Drops what is left of needles that one vertex cuts on two edges: what is across these edges meets there. */
void dropEmpty(Mesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (isEmpty(mesh.triangles[t])) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    mesh.source_triangle[kept++] = mesh.source_triangle[t];
  }
  mesh.triangles.resize(kept);
  mesh.source_triangle.resize(kept);
}

/** Fans the triangle out from the corner opposite to the edge: the last triangle has its end. */
void cut(Mesh& mesh, const Border& border, const std::vector<EdgeVertex>& cuts) {
  const Index3 v = mesh.triangles[border.triangle];
  const std::uint32_t b = v[(border.edge + 1) % 3], c = v[(border.edge + 2) % 3];
  mesh.triangles[border.triangle] = {v[border.edge], cuts.front().vertex, c};
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    mesh.triangles.push_back({cuts[i].vertex, i + 1 < cuts.size() ? cuts[i + 1].vertex : b, c});
    mesh.source_triangle.push_back(mesh.source_triangle[border.triangle]);
  }
}

/** How far a coordinate's rounding may have moved a vertex, and some: those nearer are in no order along an edge. */
double roundingAt(const Float3& p) {
  return kRounding * std::max({std::abs(double{p[0]}), std::abs(double{p[1]}), std::abs(double{p[2]})});
}

/** Ends of open edges that rounding cannot tell apart become one: cut at both, each side would have its own order. */
void joinEnds(Mesh& mesh, std::int64_t& work, BuildMonitor& monitor) {
  std::vector<std::uint32_t> ends;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t e = 0; e < 3; ++e) {
      if (mesh.neighbours[t][e] != HD_NO_INDEX) continue;
      ends.insert(ends.end(), {mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]});
    }
  }
  if (ends.empty()) return;
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  const PointTree tree(mesh.vertices, ends);
  std::vector<std::uint32_t> becomes(mesh.vertices.size());
  std::iota(becomes.begin(), becomes.end(), 0U);
  bool any = false;
  for (const std::uint32_t v : ends) {
    const Float3& p = mesh.vertices[v];
    const double near = roundingAt(p);
    tree.near({{double{p[0]}, double{p[1]}, double{p[2]}}, {}, near}, work, [&](std::uint32_t u, const Float3& x) {
      if (u >= v || becomes[u] != u || becomes[v] != v) return;
      double away2 = 0;
      for (std::size_t k = 0; k < 3; ++k) away2 += (double{x[k]} - p[k]) * (double{x[k]} - p[k]);
      if (away2 <= near * near) becomes[v] = u, any = true;
    });
  }
  if (!any) return;
  for (Index3& t : mesh.triangles)
    for (std::uint32_t& v : t) v = becomes[v];
  for (std::uint32_t& v : mesh.source_vertex) v = becomes[v];
  dropEmpty(mesh);
  dropDuplicates(mesh, monitor);  // Two that are one now would be a solid without an inside.
  BuildMonitor again;
  connect(mesh, again);
}

/** Lower than `most`. */
bool isNeedle(const Mesh& mesh, const Index3& v, double most) {
  const auto from = [&](std::uint32_t a, std::uint32_t b) {
    std::array<double, 3> d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = double{mesh.vertices[b][k]} - mesh.vertices[a][k];
    return d;
  };
  const auto squared = [](const std::array<double, 3>& d) { return d[0] * d[0] + d[1] * d[1] + d[2] * d[2]; };
  const auto u = from(v[0], v[1]), w = from(v[0], v[2]);
  const double longest2 = std::max({squared(u), squared(w), squared(from(v[1], v[2]))});
  const double twice2 = squared({u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]});
  return twice2 <= most * most * longest2;
}

/**
 * Needles cut on both long sides may be left back to back over the same three vertices, where all else about them meets
 * twice: such pairs go. Of other pairs, which are the two sides of a sheet, one stays, else there would be a hole.
 * There are none before, see dropDuplicates().
 */
bool dropFolds(Mesh& mesh, double needle) {
  std::vector<std::pair<Index3, std::uint32_t>> open;  // By their vertices.
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Index3& across = mesh.neighbours[t];
    if (std::find(across.begin(), across.end(), HD_NO_INDEX) == across.end()) continue;
    open.emplace_back(mesh.triangles[t], t);
    std::sort(open.back().first.begin(), open.back().first.end());
  }
  std::sort(open.begin(), open.end());
  bool any = false;
  for (std::size_t i = 1; i < open.size(); ++i) {
    if (open[i].first != open[i - 1].first || isEmpty(mesh.triangles[open[i - 1].second])) continue;
    if (isNeedle(mesh, open[i].first, needle)) mesh.triangles[open[i - 1].second].fill(open[i].first[0]);
    mesh.triangles[open[i].second].fill(open[i].first[0]);
    any = true;
  }
  return any;
}

/** What has been cut. */
struct Tally {
  std::size_t count = 0;
  std::uint32_t first = HD_NO_INDEX;
};

void cutAll(Mesh& mesh, std::vector<Crossed>& crossed, double weld_m, double on_edge, Tally& tally) {
  const std::size_t before = tally.count;
  std::size_t room = HD_MAX_TRIANGLES - std::min<std::size_t>(HD_MAX_TRIANGLES, mesh.triangles.size());
  for (std::size_t i = 0; i < crossed.size(); ++i) {
    const auto& [border, cuts, from_a, from_b] = crossed[i];
    if (cuts.empty() || cuts.size() > room) continue;
    const auto [triangle, edge] = border;
    tally.first = std::min(tally.first, mesh.source_triangle[triangle]);
    cut(mesh, border, cuts);
    room -= cuts.size();
    ++tally.count;
    // Its other edges are those of two triangles now.
    for (std::size_t k = i + 1; k < crossed.size() && crossed[k].border.triangle == triangle; ++k) {
      Border& other = crossed[k].border;
      other = other.edge == (edge + 1) % 3 ? Border{static_cast<std::uint32_t>(mesh.triangles.size() - 1), 1}
                                           : Border{triangle, 2};
    }
  }
  if (tally.count == before) return;
  // Twice what is on an edge, of the largest that may have been cut: both long edges of a needle, where its third
  // corner is.
  double largest = 0;
  for (const Float3& p : mesh.vertices)
    for (const float x : p) largest = std::max(largest, std::abs(double{x}));
  BuildMonitor again;
  do {
    dropEmpty(mesh);
    connect(mesh, again);
  } while (dropFolds(mesh, 2 * std::max(weld_m, on_edge * largest)));
}

}  // namespace

void stitch(Mesh& mesh, double weld_m, BuildMonitor& monitor, std::int64_t work) {
  Tally tally;
  bool gave_up = false;
  joinEnds(mesh, work, monitor);
  for (const double on_edge : kOnEdge) {
    Stitcher stitcher(mesh, weld_m, on_edge, work);
    cutAll(mesh, stitcher.crossed(), weld_m, on_edge, tally);
    gave_up = stitcher.gaveUp();
  }
  if (tally.count != 0) {
    monitor.notes.push_back(
        fmt::format("cut {} at vertices that lay on them, the first of triangle {}: else they are cracks",
                    counted(tally.count, "edge"), tally.first));
  }
  if (gave_up) {
    monitor.notes.push_back(
        "there are too many open edges to look for cracks along all of them, and a point may fall through one: close "
        "the surface, weld its vertices (hapticctl load --weld), or load it in parts");
  }
}

}  // namespace hapticd
