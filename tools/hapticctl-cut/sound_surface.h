/** @file
 * Triangles without area, as CAD programs export them, taken out of a mesh: they have no side to tell.
 */
#pragma once

#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_cut {

using hapticctl_import::Surface;

/**
 * The same points and the same closed surface without triangles whose corners lie on one line: those with a corner
 * twice are dropped; of others the corner in the middle becomes one of the triangle across the longest edge, which is
 * split there. One is kept if several triangles, or none, lie across that edge.
 */
[[nodiscard]] Surface withoutNeedles(Surface mesh);

}  // namespace hapticctl_cut
