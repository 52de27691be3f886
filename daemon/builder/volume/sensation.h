/** @file
 * What the sensation preserving descent weighs, node by node (thesis section 3.2.5).
 */
#pragma once

#include <vector>

#include "daemon/builder/volume/octree_builder.h"
#include "daemon/builder/volume/surface_points.h"

namespace hapticd {

/**
 * For each node, level by level from the root: phi = 1 - count / 8^L, count of the voxels that are surface or full
 * (eq. 3.6, corrected); and the support area D: of a surface voxel the area of the surface in its 3^3 neighbourhood
 * projected along its mean normal, of what looks the same way within 60 degrees; of a node the least of its voxels'.
 */
[[nodiscard]] std::vector<hd_octree_sensation> sensationOf(const VolumeLattice& lattice, const OctreeKeys& keys,
                                                           const std::vector<BuiltLevel>& levels,
                                                           const std::vector<std::uint64_t>& voxels,
                                                           const std::vector<SurfaceSample>& samples);

}  // namespace hapticd
