/** @file
 * Distances farther from the surface than a volume's bricks reach: the narrow band that other programs expect.
 */
#pragma once

#include <functional>

#include "daemon/builder/volume/volume_source.h"
#include "rt/volume/volume_view.h"

namespace hapticd {

/** The lattice that a volume stands on. */
[[nodiscard]] VolumeLattice latticeOf(const VolumeView& volume);

/** The distances [m] at the 9^3 lattice points from `first` on, x fastest. */
using BandVisit = std::function<void(const Lattice3& first, std::span<const float, HD_BRICK_VALUES> distances)>;

/**
 * Visits every brick cell with a lattice point nearer to the surface than `width_m`: bricks as they are, what has none
 * from `field`, which measures the same surface on latticeOf(volume). Without a field the bricks alone: they must reach
 * so far. What lies outside the lattice is at least two voxels from the surface, and not visited.
 */
void visitBand(const VolumeView& volume, DistanceField* field, double width_m, const BandVisit& visit);

}  // namespace hapticd
