/** @file
 * A solid in two: the body with its hole and the fragment that fits into it.
 */
#pragma once

#include "tools/hapticctl-cut/cut_surface.h"
#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_cut {

struct CutOptions {
  CutShape shape;
  double kerf = 0;    ///< What the saw takes away, half of it on each side of the cut.
  double voxel = 0;   ///< Steps of the lattice where the cut is ...
  double coarse = 0;  ///< ... growing to this elsewhere; below `voxel`: `voxel`.
};

struct CutParts {
  hapticctl_import::Surface body, fragment;
  std::size_t crumbs = 0;    ///< Loose pieces on the fragment's side that were left out ...
  double crumbs_volume = 0;  ///< ... and what they held [mm^3].
  std::size_t points = 0;    ///< Of the lattice.
};

/**
 * On the distances d to the mesh and c to the cut, both positive inside: the body is min(d, -c - kerf / 2), the
 * fragment min(d, c - kerf / 2), each drawn as isosurface() does. Without a kerf their faces on the cut are the same
 * triangles, turned around. Both are closed. Throws hapticctl_import::ImportError: the mesh is open, one part is empty,
 * or the lattice would be larger than memory is sure to be.
 */
[[nodiscard]] CutParts cut(const hapticctl_import::Surface& mesh, const CutOptions& options);

}  // namespace hapticctl_cut
