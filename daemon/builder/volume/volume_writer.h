/** @file
 * From distances and triangles to the flat volume of proto/volume.h.
 */
#pragma once

#include <vector>

#include "daemon/builder/volume/volume_source.h"
#include "rt/base/error.h"

namespace hapticd {

/** A block of memory aligned as sections are. */
struct alignas(64) VolumeBlock {
  std::byte bytes[64];
};

/** A flat volume in memory. */
using VolumeImage = std::vector<VolumeBlock>;

[[nodiscard]] inline std::span<const std::byte> bytesOf(const VolumeImage& image) {
  return std::as_bytes(std::span(image));
}

/**
 * Deterministic. kInvalidArgument if an option is out of range, the surface leaves the lattice, or the volume would be
 * larger than the format can hold: says how large. kBadMesh if the triangles hold no volume. kCancelled.
 */
[[nodiscard]] Result<VolumeImage> writeVolume(const VolumeSource& source, BuildMonitor& monitor);

/** kInvalidArgument for a lattice of more voxels than a volume may have. */
[[nodiscard]] Result<void> checkLattice(const VolumeLattice& lattice);

}  // namespace hapticd
