/** @file
 * Volume, centroid and inertia of the solid within a closed mesh.
 */
#pragma once

#include <span>

#include "daemon/builder/mesh/mesh.h"
#include "proto/volume.h"

namespace hapticd {

/**
 * Exact but for rounding: each triangle closes a tetrahedron with a point near the mesh, whose moments are polynomials
 * of its corners (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor", 2004). Density 1 kg/m^3.
 */
[[nodiscard]] hd_volume_mass massOf(std::span<const Float3> vertices, std::span<const Index3> triangles);

}  // namespace hapticd
