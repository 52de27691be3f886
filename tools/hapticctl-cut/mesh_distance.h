/** @file
 * The signed distance to a closed mesh at lattice points, where its sign may change.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/hapticctl-cut/lattice.h"
#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_cut {

using hapticctl_import::Surface;

/** Why a mesh encloses nothing, in words with the place of a hole; nothing if it is closed. */
[[nodiscard]] std::optional<std::string> whyOpen(const Surface& mesh);

/**
 * At both ends of every lattice edge that the mesh crosses: the distance to the nearest triangle, positive inside, its
 * sign by the angle-weighted pseudo-normal of what is nearest there (Baerentzen and Aanaes, IEEE TVCG 11(3), 2005).
 * Farther away a number of the right sign and at least a step in size. The mesh is closed and looks outward.
 */
[[nodiscard]] std::vector<float> insideness(const Surface& mesh, const Lattice& lattice);

}  // namespace hapticctl_cut
