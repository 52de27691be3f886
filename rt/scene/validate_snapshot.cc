// The check that stands between a snapshot and the servo: whoever wrote it, what passes here is safe to walk.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "rt/scene/block_check.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {
namespace {

using Float3 = MeshView::Float3;
using Index3 = MeshView::Index3;
using Corners = MeshView::Corners;

bool contains(const hd_bvh_node& node, std::uint32_t child, const float (&x)[3]) {
  for (int k = 0; k < 3; ++k)
    if (!(node.lower[k][child] <= x[k] && x[k] <= node.upper[k][child])) return false;
  return true;
}

/** One pass per section, each relying on those before it. */
class SnapshotValidator : private BlockCheck {
 public:
  explicit SnapshotValidator(std::span<const std::byte> bytes) : BlockCheck("snapshot"), bytes_(bytes) {}

  Result<MeshView> run() {
    for (const auto check :
         {&SnapshotValidator::checkHeader, &SnapshotValidator::checkSections, &SnapshotValidator::checkVertices,
          &SnapshotValidator::checkTriangles, &SnapshotValidator::checkNeighbours, &SnapshotValidator::checkTree,
          &SnapshotValidator::checkDeformable})
      if (const Result<void> passed = (this->*check)(); !passed) return passed.error();
    return view_;
  }

 private:
  Result<void> checkHeader() {
    if (auto r = header(bytes_, HD_SNAPSHOT_MAGIC, HD_SNAPSHOT_VERSION, h_); !r) return r;
    if (h_.kind != HD_SNAPSHOT_TRIANGLES) return bad("header", "kind " + std::to_string(h_.kind) + " is not known");
    if ((h_.flags & ~static_cast<std::uint32_t>(HD_MESH_CLOSED | HD_MESH_DEFORMABLE)) != 0)
      return bad("header", "a flag is not known");
    if (h_.vertex_count == 0 || h_.vertex_count > HD_MAX_VERTICES) return bad("header", "vertex count out of range");
    if (h_.triangle_count == 0 || h_.triangle_count > HD_MAX_TRIANGLES)
      return bad("header", "triangle count out of range");
    if (h_.node_count == 0 || h_.node_count > h_.triangle_count)
      return bad("header", "node count " + std::to_string(h_.node_count) + " is not that of a tree over its triangles");
    if (h_.depth == 0 || h_.depth > HD_BVH_MAX_DEPTH) return bad("header", "depth out of range");
    return {};
  }

  Result<void> checkSections() {
    const bool deformable = (h_.flags & HD_MESH_DEFORMABLE) != 0;
    const std::uint64_t many = deformable ? 4 : 0;
    const std::uint64_t source_bytes = h_.section[HD_SECTION_SOURCE_VERTEX].bytes;
    if (source_bytes % 4 != 0 || source_bytes > std::uint64_t{HD_MAX_VERTICES} * 4 ||
        (!deformable && source_bytes != 0))
      return bad("section", HD_SECTION_SOURCE_VERTEX, "has the wrong size");
    const std::uint64_t expected[HD_SECTIONS] = {std::uint64_t{h_.vertex_count} * sizeof(Float3),
                                                 std::uint64_t{h_.triangle_count} * sizeof(Index3),
                                                 std::uint64_t{h_.triangle_count} * sizeof(Index3),
                                                 std::uint64_t{h_.node_count} * sizeof(hd_bvh_node),
                                                 many * h_.node_count,
                                                 many * (std::uint64_t{h_.vertex_count} + 1),
                                                 many * 3 * h_.triangle_count,
                                                 many * h_.triangle_count,
                                                 source_bytes,
                                                 std::uint64_t{h_.triangle_count} * sizeof(Corners)};
    if (auto r = sections(h_, expected); !r) return r;
    view_.vertices = at<Float3>(HD_SECTION_VERTICES);
    view_.triangles = at<Index3>(HD_SECTION_TRIANGLES);
    view_.neighbours = at<Index3>(HD_SECTION_NEIGHBOURS);
    view_.nodes = at<hd_bvh_node>(HD_SECTION_NODES);
    view_.corners = at<Corners>(HD_SECTION_CORNERS);
    view_.vertex_count = h_.vertex_count;
    view_.triangle_count = h_.triangle_count;
    view_.node_count = h_.node_count;
    view_.depth = h_.depth;
    view_.flags = h_.flags;
    return {};
  }

  Result<void> checkVertices() {
    for (std::size_t v = 0; v < h_.vertex_count; ++v) {
      for (const float x : view_.vertices[v]) {
        if (!(std::fabs(x) <= HD_MAX_COORDINATE)) return bad("vertex", v, "a coordinate is out of range");
      }
    }
    return {};
  }

  Result<void> checkTriangles() {
    valence_.assign(h_.vertex_count, 0);
    for (std::size_t t = 0; t < h_.triangle_count; ++t) {
      const Index3& v = view_.triangles[t];
      for (const std::uint32_t i : v) {
        if (i >= h_.vertex_count) return bad("triangle", t, "an index is past the last vertex");
        ++valence_[i];
      }
      if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return bad("triangle", t, "two corners are one vertex");
      for (int c = 0; c < 3; ++c) {
        // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bit for bit
        if (std::memcmp(view_.corners[t][c], view_.vertices[v[c]], sizeof(Float3)) != 0)
          return bad("triangle", t, "its corners are not its vertices");
      }
    }
    if (*std::max_element(valence_.begin(), valence_.end()) != h_.max_valence)
      return bad("header", "the greatest valence is not " + std::to_string(h_.max_valence));
    return {};
  }

  Result<void> checkNeighbours() {
    bool closed = true;
    for (std::uint32_t t = 0; t < h_.triangle_count; ++t) {
      for (int e = 0; e < 3; ++e) {
        const std::uint32_t s = view_.neighbours[t][e];
        closed &= s != HD_NO_INDEX;
        if (s != HD_NO_INDEX && (s >= h_.triangle_count || s == t || !lookBack(t, e, s)))
          return bad("triangle", t, "its neighbour across edge " + std::to_string(e) + " does not look back");
      }
    }
    if (closed != ((h_.flags & HD_MESH_CLOSED) != 0)) return bad("header", "the flag for a closed surface is wrong");
    return {};
  }

  /** Whether s has edge e of t the other way round, and t across it. */
  [[nodiscard]] bool lookBack(std::uint32_t t, int e, std::uint32_t s) const {
    const std::uint32_t a = view_.triangles[t][e], b = view_.triangles[t][(e + 1) % 3];
    for (int f = 0; f < 3; ++f)
      if (view_.triangles[s][f] == b && view_.triangles[s][(f + 1) % 3] == a) return view_.neighbours[s][f] == t;
    return false;
  }

  Result<void> checkTree() {
    // Each node but the root is claimed by one parent before it: that makes it a tree from node 0.
    std::vector<std::uint8_t> depth(h_.node_count, 0);  // 0: not claimed yet
    std::vector<bool> held(h_.triangle_count, false);
    depth[0] = 1;
    std::uint32_t deepest = 1, held_count = 0;
    for (std::uint32_t i = 0; i < h_.node_count; ++i) {
      const hd_bvh_node& node = view_.nodes[i];
      if (depth[i] == 0) return bad("node", i, "has no parent before it");
      if (depth[i] > HD_BVH_MAX_DEPTH) return bad("node", i, "lies too deep");
      deepest = std::max<std::uint32_t>(deepest, depth[i]);
      if (node.used == 0 || node.used > HD_BVH_WIDTH) return bad("node", i, "its children are too many or none");
      for (std::uint32_t c = 0; c < node.used; ++c) {
        for (int k = 0; k < 3; ++k) {
          const float lower = node.lower[k][c], upper = node.upper[k][c];
          if (!(std::isfinite(lower) && std::isfinite(upper) && lower <= upper))
            return bad("node", i, "a box of it is not a box");
        }
        Result<void> passed = node.count[c] == 0 ? checkInner(i, c, depth) : checkLeaf(i, c, held, held_count);
        if (!passed) return passed;
      }
    }
    if (held_count != h_.triangle_count) return bad("tree", "a triangle is in no leaf");
    if (deepest != h_.depth) return bad("header", "the depth is " + std::to_string(deepest));
    const hd_bvh_node& root = view_.nodes[0];
    for (int k = 0; k < 3; ++k) {
      if (h_.lower[k] != *std::min_element(root.lower[k], root.lower[k] + root.used) ||
          h_.upper[k] != *std::max_element(root.upper[k], root.upper[k] + root.used))
        return bad("header", "its box is not that of the root");
    }
    return {};
  }

  Result<void> checkInner(std::uint32_t i, std::uint32_t c, std::vector<std::uint8_t>& depth) const {
    const hd_bvh_node& node = view_.nodes[i];
    const std::uint32_t n = node.child[c];
    if (n <= i || n >= h_.node_count) return bad("node", i, "its children are not after it");
    if (depth[n] != 0) return bad("node", n, "has two parents");
    depth[n] = static_cast<std::uint8_t>(depth[i] + 1);
    const hd_bvh_node& child = view_.nodes[n];
    if (child.used == 0 || child.used > HD_BVH_WIDTH) return bad("node", n, "its children are too many or none");
    for (std::uint32_t g = 0; g < child.used; ++g) {
      const float lower[3] = {child.lower[0][g], child.lower[1][g], child.lower[2][g]};
      const float upper[3] = {child.upper[0][g], child.upper[1][g], child.upper[2][g]};
      if (!contains(node, c, lower) || !contains(node, c, upper))
        return bad("node", i, "a box of it does not hold its children");
    }
    return {};
  }

  Result<void> checkLeaf(std::uint32_t i, std::uint32_t c, std::vector<bool>& held, std::uint32_t& held_count) const {
    const hd_bvh_node& node = view_.nodes[i];
    const std::uint32_t first = node.child[c], count = node.count[c];
    if (count > HD_BVH_LEAF_TRIANGLES || first >= h_.triangle_count || count > h_.triangle_count - first)
      return bad("node", i, "its triangles are out of range");
    for (std::uint32_t t = first; t < first + count; ++t) {
      if (held[t]) return bad("triangle", t, "is in two leaves");
      held[t] = true;
      ++held_count;
      for (const std::uint32_t v : view_.triangles[t]) {
        if (!contains(node, c, view_.vertices[v])) {
          return bad("node", i, "a box of it does not hold its triangles");
        }
      }
    }
    return {};
  }

  Result<void> checkDeformable() {
    if ((h_.flags & HD_MESH_DEFORMABLE) == 0) return {};
    if (h_.max_valence > HD_MAX_DEFORM_VALENCE) return bad("header", "too many triangles about one vertex");
    MeshView::Deform& d = view_.deform;
    d.parents = at<std::uint32_t>(HD_SECTION_PARENTS);
    d.vertex_first = at<std::uint32_t>(HD_SECTION_VERTEX_FIRST);
    d.vertex_triangles = at<std::uint32_t>(HD_SECTION_VERTEX_TRIANGLES);
    d.triangle_leaf = at<std::uint32_t>(HD_SECTION_TRIANGLE_LEAF);
    d.source_vertex = at<std::uint32_t>(HD_SECTION_SOURCE_VERTEX);
    d.source_count = static_cast<std::uint32_t>(h_.section[HD_SECTION_SOURCE_VERTEX].bytes / 4);
    if (d.parents[0] != HD_NO_INDEX) return bad("parent", 0, "the root has none");
    for (std::uint32_t i = 0; i < h_.node_count; ++i) {
      const hd_bvh_node& node = view_.nodes[i];
      for (std::uint32_t c = 0; c < node.used; ++c) {
        const std::uint32_t place = HD_BVH_WIDTH * i + c;
        if (node.count[c] == 0 && d.parents[node.child[c]] != place)
          return bad("parent", node.child[c], "is not its parent");
        for (std::uint32_t t = node.child[c]; t < node.child[c] + node.count[c]; ++t)
          if (d.triangle_leaf[t] != place) return bad("leaf of triangle", t, "does not hold it");
      }
    }
    if (auto passed = checkVertexTriangles(); !passed) return passed;
    for (std::uint32_t i = 0; i < d.source_count; ++i) {
      if (d.source_vertex[i] != HD_NO_INDEX && d.source_vertex[i] >= h_.vertex_count) {
        return bad("uploaded vertex", i, "has no vertex here");
      }
    }
    // The caller gave a private writable mapping (openSnapshot does): only then may moveVertex() be used.
    d.vertices = const_cast<Float3*>(view_.vertices);
    d.corners = const_cast<Corners*>(view_.corners);
    d.nodes = const_cast<hd_bvh_node*>(view_.nodes);
    return {};
  }

  Result<void> checkVertexTriangles() const {
    const MeshView::Deform& d = view_.deform;
    if (d.vertex_first[0] != 0) return bad("triangles of vertex", 0, "do not begin at 0");
    for (std::uint32_t v = 0; v < h_.vertex_count; ++v) {
      // By sums, not differences: valence_ is true, so this keeps vertex_first in range all along.
      if (d.vertex_first[v + 1] != d.vertex_first[v] + valence_[v])
        return bad("triangles of vertex", v, "are not as many as it has");
      for (std::uint32_t i = d.vertex_first[v]; i < d.vertex_first[v + 1]; ++i) {
        const std::uint32_t t = d.vertex_triangles[i];
        if (t >= h_.triangle_count || (i > d.vertex_first[v] && t <= d.vertex_triangles[i - 1]) ||
            std::find(view_.triangles[t], view_.triangles[t] + 3, v) == view_.triangles[t] + 3)
          return bad("triangles of vertex", v, "are not its triangles");
      }
    }
    return {};
  }

  template <class T>
  const T* at(hd_snapshot_section section) const {
    return reinterpret_cast<const T*>(bytes_.data() + h_.section[section].offset);
  }

  std::span<const std::byte> bytes_;
  hd_snapshot_header h_{};
  MeshView view_;
  std::vector<std::uint32_t> valence_;
};

}  // namespace

Result<MeshView> validateSnapshot(std::span<const std::byte> bytes) { return SnapshotValidator(bytes).run(); }

}  // namespace hapticd
