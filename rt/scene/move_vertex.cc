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

/** Stores the box; false if it was the same already. */
bool replaceBox(hd_bvh_node& node, const Bounds& box) HD_RT {
  bool changed = false;
  for (int k = 0; k < 3; ++k) {
    changed |= node.lower[k] != box.lower[k] || node.upper[k] != box.upper[k];
    node.lower[k] = box.lower[k];
    node.upper[k] = box.upper[k];
  }
  return changed;
}

Bounds boundsOfLeaf(const MeshView& mesh, const hd_bvh_node& leaf) HD_RT {
  Bounds box;
  const float(&start)[3] = mesh.vertices[mesh.triangles[leaf.first][0]];
  std::copy_n(start, 3, box.lower);
  std::copy_n(start, 3, box.upper);
  for (std::uint32_t t = leaf.first; t < leaf.first + leaf.count; ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], mesh.vertices[v][k]);
        box.upper[k] = std::max(box.upper[k], mesh.vertices[v][k]);
      }
  return box;
}

Bounds boundsOfChildren(const MeshView& mesh, const hd_bvh_node& node) HD_RT {
  Bounds box;
  const hd_bvh_node &a = mesh.nodes[node.first], &b = mesh.nodes[node.first + 1];
  for (int k = 0; k < 3; ++k) {
    box.lower[k] = std::min(a.lower[k], b.lower[k]);
    box.upper[k] = std::max(a.upper[k], b.upper[k]);
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
  std::copy_n(p, 3, d.vertices[v]);
  // At most HD_MAX_DEFORM_VALENCE leaves times HD_BVH_MAX_DEPTH boxes. Every box is the exact union of what is below it
  // before and after each leaf's turn, so a box that stays the same ends the climb.
  for (std::uint32_t i = d.vertex_first[v]; i < d.vertex_first[v + 1]; ++i) {
    std::uint32_t n = d.triangle_leaf[d.vertex_triangles[i]];
    bool changed = replaceBox(d.nodes[n], boundsOfLeaf(mesh, d.nodes[n]));
    for (n = d.parents[n]; changed && n != HD_NO_INDEX; n = d.parents[n])
      changed = replaceBox(d.nodes[n], boundsOfChildren(mesh, d.nodes[n]));
  }
  return ErrorCode::kOk;
}

}  // namespace hapticd
