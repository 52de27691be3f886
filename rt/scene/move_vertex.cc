// Vertex moves: a bottom-up refit, exact, so that boxes shrink as well as grow.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "rt/scene/mesh_view.h"

namespace hapticd {
namespace {

struct Bounds {
  float lower[3], upper[3];
};

/** Stores the box of a child; false if it was the same already. */
bool replaceBox(hd_bvh_node& node, std::uint32_t child, const Bounds& box) HD_RT {
  bool changed = false;
  for (int k = 0; k < 3; ++k) {
    changed |= node.lower[k][child] != box.lower[k] || node.upper[k][child] != box.upper[k];
    node.lower[k][child] = box.lower[k];
    node.upper[k][child] = box.upper[k];
  }
  return changed;
}

Bounds boundsOfLeaf(const MeshView& mesh, std::uint32_t first, std::uint32_t count) HD_RT {
  Bounds box;
  const float(&start)[3] = mesh.corners[first][0];
  std::copy_n(start, 3, box.lower);
  std::copy_n(start, 3, box.upper);
  for (std::uint32_t t = first; t < first + count; ++t)
    for (const auto& corner : mesh.corners[t])
      for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], corner[k]);
        box.upper[k] = std::max(box.upper[k], corner[k]);
      }
  return box;
}

Bounds boundsOfNode(const hd_bvh_node& node) HD_RT {
  Bounds box;
  for (int k = 0; k < 3; ++k) {
    box.lower[k] = *std::min_element(node.lower[k], node.lower[k] + node.used);
    box.upper[k] = *std::max_element(node.upper[k], node.upper[k] + node.used);
  }
  return box;
}

}  // namespace

ErrorCode moveVertex(MeshView& mesh, std::uint32_t vertex, const float (&p)[3]) HD_RT {
  MeshView::Deform& d = mesh.deform;
  if (d.vertices == nullptr) return ErrorCode::kUnsupported;
  if (vertex >= d.source_count) return ErrorCode::kNotFound;
  for (const float x : p)
    if (!(std::fabs(x) <= HD_MAX_COORDINATE)) return ErrorCode::kInvalidArgument;
  const std::uint32_t v = d.source_vertex[vertex];
  if (v == HD_NO_INDEX) return ErrorCode::kOk;  // of no triangle: nothing to move
  ++d.moves;
  std::copy_n(p, 3, d.vertices[v]);
  for (std::uint32_t i = d.vertex_first[v]; i < d.vertex_first[v + 1]; ++i) {
    const std::uint32_t t = d.vertex_triangles[i];
    for (int c = 0; c < 3; ++c)
      if (mesh.triangles[t][c] == v) std::copy_n(p, 3, d.corners[t][c]);
  }
  // At most HD_MAX_DEFORM_VALENCE leaves times HD_BVH_MAX_DEPTH boxes. Every box is the exact union of what is below it
  // before and after each leaf's turn, so a box that stays the same ends the climb.
  for (std::uint32_t i = d.vertex_first[v]; i < d.vertex_first[v + 1]; ++i) {
    std::uint32_t place = d.triangle_leaf[d.vertex_triangles[i]];
    std::uint32_t n = place / HD_BVH_WIDTH, child = place % HD_BVH_WIDTH;
    Bounds box = boundsOfLeaf(mesh, d.nodes[n].child[child], d.nodes[n].count[child]);
    while (replaceBox(d.nodes[n], child, box) && d.parents[n] != HD_NO_INDEX) {
      box = boundsOfNode(d.nodes[n]);
      place = d.parents[n];
      n = place / HD_BVH_WIDTH;
      child = place % HD_BVH_WIDTH;
    }
  }
  return ErrorCode::kOk;
}

}  // namespace hapticd
