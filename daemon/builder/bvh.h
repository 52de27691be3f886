/** @file
 * The bounding volume hierarchy of a mesh: binary, axis-aligned, by the surface area heuristic.
 */
#pragma once

#include <vector>

#include "daemon/builder/mesh.h"

namespace hapticd {

/** Nodes as proto/snapshot.h wants them, and the triangles in leaf order. */
struct Bvh {
  std::vector<hd_bvh_node> nodes;    ///< Root first; siblings adjacent; children after parents.
  std::vector<std::uint32_t> order;  ///< order[i]: the mesh's triangle that stands at place i.
  std::uint32_t depth = 0;           ///< At most HD_BVH_MAX_DEPTH.
};

/**
 * Binned surface area heuristic (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007), by the
 * median where binning cannot split or where the depth would grow past the limit. Boxes are exact: vertices are floats.
 * Deterministic. `progress` gets 0 to 1; false from it stops early and leaves `nodes` empty.
 */
[[nodiscard]] Bvh buildBvh(const Mesh& mesh, const std::function<bool(float)>& progress);

}  // namespace hapticd
