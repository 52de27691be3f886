/** @file
 * The bounding volume hierarchy of a mesh: axis-aligned, by the surface area heuristic, eight children a node.
 */
#pragma once

#include <vector>

#include "daemon/builder/mesh/mesh.h"

namespace hapticd {

/** Nodes as proto/snapshot.h wants them, and the triangles in leaf order. */
struct Bvh {
  std::vector<hd_bvh_node> nodes;    ///< Root first; children after parents.
  std::vector<std::uint32_t> order;  ///< order[i]: the mesh's triangle that stands at place i.
  std::uint32_t depth = 0;           ///< At most HD_BVH_MAX_DEPTH.
};

/** A node of the binary tree from which the wide one is made. */
struct BinaryNode {
  float lower[3];
  std::uint32_t first;  ///< Leaf: first triangle. Inner: the left child; the right child is first + 1.
  float upper[3];
  std::uint32_t count;  ///< Leaf: triangles, 1 to HD_BVH_LEAF_TRIANGLES. Inner: 0.
};

/**
 * Binned surface area heuristic (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007), by the
 * median where binning cannot split or where the depth would grow past the limit. Boxes are exact: vertices are floats.
 * Deterministic. `progress` gets 0 to 1; false from it stops early and leaves `nodes` empty.
 */
[[nodiscard]] Bvh buildBvh(const Mesh& mesh, const std::function<bool(float)>& progress);

/**
 * Makes nodes of eight children out of a binary tree: from each node's two, the inner child of the largest surface is
 * replaced by its own two until there are eight (Wald, Benthin, Boulos, "Getting rid of packets", 2008). In depth-first
 * order, children from left to right. `depth` receives that of the result.
 */
[[nodiscard]] std::vector<hd_bvh_node> widen(const std::vector<BinaryNode>& binary, std::uint32_t& depth);

}  // namespace hapticd
