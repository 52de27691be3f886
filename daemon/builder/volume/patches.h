/** @file
 * Surface points sorted into the octree nodes of one level.
 */
#pragma once

#include <vector>

#include "daemon/builder/volume/octree_builder.h"
#include "daemon/builder/volume/surface_points.h"

namespace hapticd {

/** The level whose nodes hold, on average, the number of points nearest to `wanted` by ratio. */
[[nodiscard]] std::uint32_t patchLevel(const std::vector<BuiltLevel>& levels, std::size_t points, std::size_t wanted);

/**
 * Reorders the points by node, each node's by coverage; one patch per node, empty ones too. Reports progress from 0.95
 * on; no patches once the monitor has asked to stop.
 */
[[nodiscard]] std::vector<hd_volume_patch> makePatches(const VolumeLattice& lattice, const OctreeKeys& keys,
                                                       std::uint32_t level, const std::vector<std::uint64_t>& prefixes,
                                                       std::vector<SurfaceSample>& points, BuildMonitor& monitor);

}  // namespace hapticd
