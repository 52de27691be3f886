/** @file
 * Where a mesh that encloses nothing ends.
 */
#pragma once

#include "rt/geometry/nearest/nearest.h"

namespace hapticd {

/** Whether a mesh's nearest point is on its border: on an edge of one triangle, or an end of such an edge. */
[[nodiscard]] bool isOnBorder(const MeshView& mesh, const Nearest& nearest) HD_RT;

}  // namespace hapticd
