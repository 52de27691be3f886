#include "daemon/builder/mesh/snapshot_writer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>

#include "daemon/builder/mesh/counted.h"
#include "rt/scene/snapshot_checksum.h"

namespace hapticd {
namespace {

std::uint64_t aligned(std::uint64_t bytes) { return (bytes + 63) / 64 * 64; }

/** Lays sections one after the other and then fills them in place. */
class SnapshotLayout {
 public:
  explicit SnapshotLayout(hd_snapshot_header& header) : header_(header) {}
  template <class T>
  void add(hd_snapshot_section section, std::uint64_t count) {
    header_.section[section] = {end_, count * sizeof(T)};
    end_ = aligned(end_ + count * sizeof(T));
  }
  [[nodiscard]] std::uint64_t total() const { return end_; }

 private:
  hd_snapshot_header& header_;
  std::uint64_t end_ = aligned(sizeof(hd_snapshot_header));
};

template <class T>
T* sectionOf(const Mapping& mapping, hd_snapshot_section section) {
  return reinterpret_cast<T*>(mapping.data() + mapping.as<hd_snapshot_header>()->section[section].offset);
}

/** The mesh renumbered: triangles by leaf, vertices by first use. */
struct Numbering {
  std::vector<std::uint32_t> place;       ///< New number of each triangle.
  std::vector<std::uint32_t> new_vertex;  ///< New number of each vertex; HD_NO_INDEX if no triangle uses it.
  std::vector<std::uint32_t> used;        ///< The vertices in their new order.
  std::vector<std::uint32_t> valence;     ///< Triangles about each new vertex.
};

Numbering renumber(const Mesh& mesh, const Bvh& bvh) {
  Numbering n;
  n.place.resize(mesh.triangles.size());
  n.new_vertex.assign(mesh.vertices.size(), HD_NO_INDEX);
  n.used.reserve(mesh.vertices.size());
  n.valence.reserve(mesh.vertices.size());
  for (std::uint32_t i = 0; i < bvh.order.size(); ++i) {
    if (i + 2 * kFetchAhead < bvh.order.size()) {
      __builtin_prefetch(&mesh.triangles[bvh.order[i + 2 * kFetchAhead]]);
      for (const std::uint32_t v : mesh.triangles[bvh.order[i + kFetchAhead]]) __builtin_prefetch(&n.new_vertex[v]);
    }
    n.place[bvh.order[i]] = i;
    for (const std::uint32_t v : mesh.triangles[bvh.order[i]]) {
      if (n.new_vertex[v] == HD_NO_INDEX) {
        n.new_vertex[v] = static_cast<std::uint32_t>(n.used.size());
        n.used.push_back(v);
        n.valence.push_back(0);
      }
      ++n.valence[n.new_vertex[v]];
    }
  }
  return n;
}

void fillTriangles(const Mapping& mapping, const Mesh& mesh, const Bvh& bvh, const Numbering& n) {
  auto* const vertices = sectionOf<Float3>(mapping, HD_SECTION_VERTICES);
  for (std::size_t i = 0; i < n.used.size(); ++i) vertices[i] = mesh.vertices[n.used[i]];
  auto* const triangles = sectionOf<Index3>(mapping, HD_SECTION_TRIANGLES);
  auto* const neighbours = sectionOf<Index3>(mapping, HD_SECTION_NEIGHBOURS);
  auto* const corners = sectionOf<std::array<Float3, 3>>(mapping, HD_SECTION_CORNERS);
  for (std::size_t i = 0; i < bvh.order.size(); ++i) {
    const std::uint32_t t = bvh.order[i];
    if (i + 2 * kFetchAhead < bvh.order.size()) {
      __builtin_prefetch(&mesh.triangles[bvh.order[i + 2 * kFetchAhead]]);
      __builtin_prefetch(&mesh.neighbours[bvh.order[i + 2 * kFetchAhead]]);
      const std::uint32_t next = bvh.order[i + kFetchAhead];
      for (const std::uint32_t v : mesh.triangles[next]) {
        __builtin_prefetch(&n.new_vertex[v]);
        __builtin_prefetch(&mesh.vertices[v]);
      }
      for (const std::uint32_t s : mesh.neighbours[next])
        if (s != HD_NO_INDEX) __builtin_prefetch(&n.place[s]);
    }
    for (int k = 0; k < 3; ++k) {
      triangles[i][k] = n.new_vertex[mesh.triangles[t][k]];
      corners[i][k] = mesh.vertices[mesh.triangles[t][k]];
      const std::uint32_t s = mesh.neighbours[t][k];
      neighbours[i][k] = s == HD_NO_INDEX ? s : n.place[s];
    }
  }
  std::memcpy(sectionOf<hd_bvh_node>(mapping, HD_SECTION_NODES), bvh.nodes.data(),
              bvh.nodes.size() * sizeof(hd_bvh_node));
}

/** What vertex moves need: from vertex to triangles to leaves and up. */
void fillDeformable(const Mapping& mapping, const Mesh& mesh, const Bvh& bvh, const Numbering& n) {
  auto* const parents = sectionOf<std::uint32_t>(mapping, HD_SECTION_PARENTS);
  auto* const leaves = sectionOf<std::uint32_t>(mapping, HD_SECTION_TRIANGLE_LEAF);
  parents[0] = HD_NO_INDEX;
  for (std::uint32_t i = 0; i < bvh.nodes.size(); ++i) {
    const hd_bvh_node& node = bvh.nodes[i];
    for (std::uint32_t c = 0; c < node.used; ++c) {
      const std::uint32_t place = HD_BVH_WIDTH * i + c;
      if (node.count[c] == 0) parents[node.child[c]] = place;
      std::fill_n(leaves + node.child[c], node.count[c], place);
    }
  }
  auto* const first = sectionOf<std::uint32_t>(mapping, HD_SECTION_VERTEX_FIRST);
  first[0] = 0;
  for (std::size_t v = 0; v < n.valence.size(); ++v) first[v + 1] = first[v] + n.valence[v];
  auto* const about = sectionOf<std::uint32_t>(mapping, HD_SECTION_VERTEX_TRIANGLES);
  const auto* const triangles = sectionOf<Index3>(mapping, HD_SECTION_TRIANGLES);
  std::vector<std::uint32_t> fill(first, first + n.valence.size());
  for (std::uint32_t t = 0; t < bvh.order.size(); ++t)
    for (const std::uint32_t v : triangles[t]) about[fill[v]++] = t;
  auto* const source = sectionOf<std::uint32_t>(mapping, HD_SECTION_SOURCE_VERTEX);
  for (std::size_t i = 0; i < mesh.source_vertex.size(); ++i) source[i] = n.new_vertex[mesh.source_vertex[i]];
}

}  // namespace

Result<Memfd> writeSnapshot(const Mesh& mesh, const Bvh& bvh, BuildMonitor& monitor) {
  const Numbering n = renumber(mesh, bvh);
  if (n.used.size() < mesh.vertices.size()) {
    monitor.notes.push_back(
        fmt::format("dropped {} of no triangle", counted(mesh.vertices.size() - n.used.size(), "vertex", "vertices")));
  }
  const auto widest = std::max_element(n.valence.begin(), n.valence.end());
  if (mesh.deformable && *widest > HD_MAX_DEFORM_VALENCE) {
    const std::uint32_t v = n.used[static_cast<std::size_t>(widest - n.valence.begin())];
    const auto source = std::find(mesh.source_vertex.begin(), mesh.source_vertex.end(), v) - mesh.source_vertex.begin();
    return Error{ErrorCode::kBadMesh, fmt::format("vertex {}", source),
                 fmt::format("{} triangles meet there; a deformable mesh may have {}", *widest, HD_MAX_DEFORM_VALENCE),
                 "split the fan, or load the mesh as rigid"};
  }

  hd_snapshot_header header{};
  header.magic = HD_SNAPSHOT_MAGIC;
  header.version = HD_SNAPSHOT_VERSION;
  header.kind = HD_SNAPSHOT_TRIANGLES;
  header.flags = 0;
  if (mesh.closed) header.flags |= HD_MESH_CLOSED;
  if (mesh.deformable) header.flags |= HD_MESH_DEFORMABLE;
  header.vertex_count = static_cast<std::uint32_t>(n.used.size());
  header.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  header.node_count = static_cast<std::uint32_t>(bvh.nodes.size());
  const hd_bvh_node& root = bvh.nodes[0];
  for (int k = 0; k < 3; ++k) {
    header.lower[k] = *std::min_element(root.lower[k], root.lower[k] + root.used);
    header.upper[k] = *std::max_element(root.upper[k], root.upper[k] + root.used);
  }
  header.depth = bvh.depth;
  header.max_valence = *widest;
  SnapshotLayout layout(header);
  layout.add<Float3>(HD_SECTION_VERTICES, header.vertex_count);
  layout.add<Index3>(HD_SECTION_TRIANGLES, header.triangle_count);
  layout.add<Index3>(HD_SECTION_NEIGHBOURS, header.triangle_count);
  layout.add<hd_bvh_node>(HD_SECTION_NODES, header.node_count);
  const std::uint64_t many = mesh.deformable ? 1 : 0;
  layout.add<std::uint32_t>(HD_SECTION_PARENTS, many * header.node_count);
  layout.add<std::uint32_t>(HD_SECTION_VERTEX_FIRST, many * (header.vertex_count + 1));
  layout.add<std::uint32_t>(HD_SECTION_VERTEX_TRIANGLES, many * header.triangle_count * 3);
  layout.add<std::uint32_t>(HD_SECTION_TRIANGLE_LEAF, many * header.triangle_count);
  layout.add<std::uint32_t>(HD_SECTION_SOURCE_VERTEX, many * mesh.source_vertex.size());
  layout.add<std::array<Float3, 3>>(HD_SECTION_CORNERS, header.triangle_count);
  header.total_bytes = layout.total();

  auto memfd = Memfd::create("hapticd-mesh", header.total_bytes);
  if (!memfd) return memfd;
  {
    auto mapping = memfd->map(Memfd::Access::kWrite);
    if (!mapping) return mapping.error();
    *mapping->as<hd_snapshot_header>() = header;
    fillTriangles(*mapping, mesh, bvh, n);
    if (mesh.deformable) fillDeformable(*mapping, mesh, bvh, n);
    mapping->as<hd_snapshot_header>()->checksum = snapshotChecksum(mapping->bytes().subspan(sizeof header));
  }
  if (const auto sealed = memfd->seal(Seals::kFrozen); !sealed) return sealed.error();
  return memfd;
}

}  // namespace hapticd
