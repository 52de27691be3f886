/** @file
 * A stroke over any mesh.
 */
#pragma once

#include <vector>

#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/trajectory/generators.h"

namespace haptic_bench {

/**
 * The straightest way (Polthier and Schmies 1998) over the mesh: straight in a facet, and over an edge as if both
 * facets lay in one plane; at a border it turns back. It begins on the facet whose middle is nearest to `from`, at
 * `azimuth` [rad] about its normal against the world's x (y where the facet faces along x), at `speed` [m/s]. The
 * normals are those of the vertices, interpolated: the smooth surface that the facets stand for; the facet's own
 * where those cancel, as on a sheet of two sides. Triangles without area are mended before (tools/mesh_file/flat.h).
 * Throws Failure where that cannot be done in its way.
 */
[[nodiscard]] std::vector<SurfaceSample> geodesic(const Model& given, const Pace& pace, double speed, double azimuth,
                                                  const Vec3& from);

}  // namespace haptic_bench
