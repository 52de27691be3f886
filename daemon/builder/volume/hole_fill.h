/** @file
 * The surface that closes the holes of an open mesh: where its winding number is one half.
 */
#pragma once

#include "daemon/builder/volume/volume_source.h"
#include "daemon/builder/volume/winding.h"

namespace hapticd {

struct HoleFill {
  std::vector<Float3> vertices;   ///< [m], in the object's frame.
  std::vector<Index3> triangles;  ///< Outward.
};

/**
 * The winding number jumps by one across the mesh and passes through one half across its holes (Jacobson, Kavan,
 * Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding numbers", SIGGRAPH 2013). That surface
 * is flat in a flat hole. It is followed from the borders of the mesh over the lattice's voxels, each cut into six
 * tetrahedra; it meets the mesh within a voxel of the border. Gaps much smaller than a voxel need no fill and get none.
 * A call of `monitor` for every 64 voxels. kBadMesh if nowhere near a border there is an inside; kCancelled.
 */
[[nodiscard]] Result<HoleFill> fillHoles(const MeshView& mesh, const WindingTree& winding, const VolumeLattice& lattice,
                                         BuildMonitor& monitor);

}  // namespace hapticd
