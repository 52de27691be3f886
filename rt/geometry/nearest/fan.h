/** @file
 * The triangles about a vertex, one after the other over their common edges.
 */
#pragma once

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"

namespace hapticd {

/** Calls visit(triangle, its corner there) from t on in both directions, at most kMaxFan each, until it says so;
 * whether it did. `mesh` has neighbours. Servo-safe. */
template <class Visit>
bool anyAbout(const MeshView& mesh, std::uint32_t t, std::uint32_t vertex, const Visit& visit) HD_RT {
  for (const std::uint32_t side : {0u, 2u}) {  // Over the edge that leaves the vertex, or back over the one that comes.
    std::uint32_t at = t;
    for (int i = 0; i < kMaxFan && at != HD_NO_INDEX; ++i) {
      const std::uint32_t here = cornerOf(mesh, at, vertex);
      if (visit(at, here)) return true;
      at = mesh.neighbours[at][(here + side) % 3];
      if (at == t) return false;  // All the way round.
    }
  }
  return false;
}

}  // namespace hapticd
