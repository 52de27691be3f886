/** @file
 * A volume from a closed triangle mesh, by the exact distance to it.
 */
#pragma once

#include "daemon/builder/volume/volume_writer.h"

namespace hapticd {

/**
 * The mesh as uploaded: it is welded, cleaned and turned outward first. kBadMesh for an open one, with the place of a
 * hole; else as buildSnapshot() and writeVolume(). Some 2 us for each lattice point near the surface.
 */
[[nodiscard]] Result<VolumeImage> buildMeshVolume(std::span<const std::byte> upload, double voxel_m,
                                                  const VolumeOptions& options, BuildMonitor& monitor);

/** The same from arrays. */
[[nodiscard]] Result<VolumeImage> buildMeshVolume(std::span<const Float3> vertices, std::span<const Index3> triangles,
                                                  double voxel_m, const VolumeOptions& options, BuildMonitor& monitor);

}  // namespace hapticd
