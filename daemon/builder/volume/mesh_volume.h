/** @file
 * A volume from a triangle mesh, by the exact distance to it; closed, or with its holes filled.
 */
#pragma once

#include "daemon/builder/volume/volume_writer.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * The mesh as uploaded: it is welded, cleaned and turned outward first. kBadMesh for an open one, with the place of a
 * hole, unless options.fill_holes; else as buildSnapshot() and writeVolume(). Some 2 us for each lattice point near the
 * surface.
 */
[[nodiscard]] Result<VolumeImage> buildMeshVolume(std::span<const std::byte> upload, double voxel_m,
                                                  const VolumeOptions& options, BuildMonitor& monitor);

/**
 * Of a mesh that is built already. kInvalidArgument for a volume too large for this process's memory: says how much it
 * would take.
 */
[[nodiscard]] Result<VolumeImage> volumeOfMesh(const MeshView& mesh, double voxel_m, const VolumeOptions& options,
                                               BuildMonitor& monitor);

/** What building a surface's volume costs grows with. */
struct SurfaceExtent {
  double area = 0;     ///< [m^2]
  double samples = 0;  ///< At most, as mostSamples() has it: needles have many more than their area says.
};
/** Counts what is fine, in seconds at most; kCancelled when the monitor says so. */
[[nodiscard]] Result<SurfaceExtent> extentOf(const MeshView& mesh, double voxel_m, BuildMonitor& monitor);
/** Bytes that building takes at most at a time, about: known before the long work. */
[[nodiscard]] double bytesToBuild(const VolumeLattice& lattice, const SurfaceExtent& surface,
                                  const VolumeOptions& options);

/** The same from arrays. */
[[nodiscard]] Result<VolumeImage> buildMeshVolume(std::span<const Float3> vertices, std::span<const Index3> triangles,
                                                  double voxel_m, const VolumeOptions& options, BuildMonitor& monitor);

}  // namespace hapticd
