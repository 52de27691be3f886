/** @file
 * Depth in a convex solid made of half-spaces, with rounded edges so that the force has no jump between faces.
 */
#pragma once

#include <cstdint>

#include "proto/shm_layout.h"
#include "rt/base/math.h"

namespace hapticd {

/** A smooth depth: the force k depth * normal is the gradient of k depth^2 / 2, so the solid is conservative. */
struct SolidDepth {
  double depth = 0;            ///< [m]; positive inside.
  Vec3 normal = Vec3::Zero();  ///< -grad(depth): unit on a face, shorter at an edge.
};

/**
 * From inside a convex polytope the nearest point of its surface lies on the face with the least slack
 * s_i = d_i - n_i.x. The bare minimum has a jump in its gradient where two faces are equally near, so it is smoothed:
 *
 *   depth = min over the simplex of sum(l_i s_i) + (rounding / 2) (|l|^2 - 1),  normal = sum(l_i n_i)
 *
 * One face alone within `rounding` of the least slack: exactly the face. m equal faces: rounding (1 - 1/m) / 2 less
 * deep, the fillet of the edge. The gradient is continuous, with |change of normal| <= |change of x| m / rounding.
 *
 * `halfspace` holds unit n and d (hd_local_model), 1 <= count <= HD_HALFSPACES, rounding > 0, x about their origin.
 */
[[nodiscard]] SolidDepth solidDepth(const float (*halfspace)[4], std::uint32_t count, double rounding,
                                    const Vec3& x) HD_RT;

}  // namespace hapticd
