// Equal or near vertices become one; triangles without area and doubled triangles go.
#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "daemon/builder/mesh/counted.h"
#include "daemon/builder/mesh/near_table.h"

namespace hapticd {
namespace {

/** A triangle lower than this fraction of its longest edge has no direction: float rounds coordinates by 6e-8. */
constexpr double kThinnest = 1e-7;

struct Key {
  std::uint32_t x, y, z;
  bool operator==(const Key&) const = default;
};

Key keyOf(const Float3& p) {
  // Adding zero turns -0 into +0.
  return {std::bit_cast<std::uint32_t>(p[0] + 0.0f), std::bit_cast<std::uint32_t>(p[1] + 0.0f),
          std::bit_cast<std::uint32_t>(p[2] + 0.0f)};
}

std::uint64_t hash(const Key& k) {
  std::uint64_t h = (std::uint64_t{k.x} << 32 | k.y) * UINT64_C(0x9e3779b97f4a7c15);
  h = (h ^ (h >> 29) ^ k.z) * UINT64_C(0xbf58476d1ce4e5b9);
  return h ^ (h >> 32);
}

/** Open addressing over vertex numbers; at most half full. */
class VertexTable {
 public:
  explicit VertexTable(std::size_t count) : slots_(std::bit_ceil(count * 2), HD_NO_INDEX), mask_(slots_.size() - 1) {}

  std::uint32_t findOrAdd(const Float3& p, std::vector<Float3>& vertices) {
    const Key key = keyOf(p);
    for (std::size_t i = hash(key) & mask_;; i = (i + 1) & mask_) {
      if (slots_[i] == HD_NO_INDEX) {
        slots_[i] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back({p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f});
        return slots_[i];
      }
      if (keyOf(vertices[slots_[i]]) == key) return slots_[i];
    }
  }

 private:
  std::vector<std::uint32_t> slots_;
  std::size_t mask_;
};

bool hasArea(const Float3& a, const Float3& b, const Float3& c) {
  double u[3], v[3], w[3];
  double uu = 0, vv = 0, ww = 0;
  for (int k = 0; k < 3; ++k) {
    u[k] = double{b[k]} - a[k];
    v[k] = double{c[k]} - a[k];
    w[k] = double{c[k]} - b[k];
    uu += u[k] * u[k];
    vv += v[k] * v[k];
    ww += w[k] * w[k];
  }
  const double nx = u[1] * v[2] - u[2] * v[1], ny = u[2] * v[0] - u[0] * v[2], nz = u[0] * v[1] - u[1] * v[0];
  const double longest = std::max({uu, vv, ww});
  return std::sqrt(nx * nx + ny * ny + nz * nz) > kThinnest * longest;
}

}  // namespace

Mesh weld(const MeshSource& source, BuildMonitor& monitor) {
  Mesh mesh;
  mesh.deformable = source.deformable;
  mesh.source_vertex.resize(source.vertices.size());
  mesh.vertices.reserve(source.vertices.size());
  const auto join = [&](auto table) {
    for (std::size_t i = 0; i < source.vertices.size(); ++i)
      mesh.source_vertex[i] = table.findOrAdd(source.vertices[i], mesh.vertices);
  };
  if (source.weld_m > 0) {
    join(NearTable(source.vertices.size(), source.weld_m));
  } else {
    join(VertexTable(source.vertices.size()));
  }
  if (mesh.vertices.size() < source.vertices.size()) {
    const std::string how = source.weld_m > 0 ? fmt::format("more than {} m apart", source.weld_m) : "of equal place";
    monitor.notes.push_back(
        fmt::format("welded {} vertices into {} {}", source.vertices.size(), mesh.vertices.size(), how));
  }

  mesh.triangles.reserve(source.triangles.size());
  mesh.source_triangle.reserve(source.triangles.size());
  std::size_t first_dropped = 0, dropped = 0;
  for (std::size_t t = 0; t < source.triangles.size(); ++t) {
    Index3 corners;
    for (int k = 0; k < 3; ++k) corners[k] = mesh.source_vertex[source.triangles[t][k]];
    if (hasArea(mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]])) {
      mesh.triangles.push_back(corners);
      mesh.source_triangle.push_back(static_cast<std::uint32_t>(t));
    } else if (dropped++ == 0) {
      first_dropped = t;
    }
  }
  if (dropped != 0) {
    monitor.notes.push_back(
        fmt::format("removed {} without area, the first is triangle {}", counted(dropped, "triangle"), first_dropped));
  }
  return mesh;
}

void dropDuplicates(Mesh& mesh, BuildMonitor& monitor) {
  // Triangles by their lowest vertex; within one such bucket, sort by the other two.
  struct Entry {
    std::uint64_t others;
    std::uint32_t triangle;
    bool operator<(const Entry& o) const { return others != o.others ? others < o.others : triangle < o.triangle; }
  };
  const auto sorted = [&](std::uint32_t t) {
    Index3 v = mesh.triangles[t];
    std::sort(v.begin(), v.end());
    return v;
  };
  std::vector<std::uint32_t> start(mesh.vertices.size() + 1, 0);
  for (const Index3& v : mesh.triangles) ++start[std::min({v[0], v[1], v[2]}) + 1];
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  std::vector<Entry> entries(mesh.triangles.size());
  std::vector<std::uint32_t> fill(start.begin(), start.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Index3 v = sorted(t);
    entries[fill[v[0]]++] = {std::uint64_t{v[1]} << 32 | v[2], t};
  }
  std::vector<bool> doubled(mesh.triangles.size(), false);
  std::size_t count = 0;
  std::uint32_t first = HD_NO_INDEX;
  for (std::size_t b = 0; b + 1 < start.size(); ++b) {
    if (start[b + 1] - start[b] < 2) continue;
    std::sort(entries.begin() + start[b], entries.begin() + start[b + 1]);
    for (std::uint32_t i = start[b] + 1; i < start[b + 1]; ++i) {
      if (entries[i].others != entries[i - 1].others) continue;
      doubled[entries[i].triangle] = true;
      first = std::min(first, mesh.source_triangle[entries[i].triangle]);
      ++count;
    }
  }
  if (count == 0) return;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (doubled[t]) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    mesh.source_triangle[kept++] = mesh.source_triangle[t];
  }
  mesh.triangles.resize(kept);
  mesh.source_triangle.resize(kept);
  monitor.notes.push_back(
      fmt::format("removed {}, the first is triangle {}", counted(count, "doubled triangle"), first));
}

}  // namespace hapticd
