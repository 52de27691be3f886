/** @file
 * Depth in solids made of half-spaces: all of them together (convex) or any of them (a corner). Both are conservative,
 * and their force has no jump between faces.
 */
#pragma once

#include <cstdint>

#include "proto/shm_layout.h"
#include "rt/base/math.h"

namespace hapticd {

/** A smooth depth: the force k depth * normal is minus the gradient of k depth^2 / 2, so the solid is conservative. */
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

/**
 * Way from x to the nearest point outside all half-spaces: the proxy of a god-object held by these planes (Zilles and
 * Salisbury, IROS 1995), found by projection on the intersection of their outsides,
 *
 *   min over e of |e|^2 / 2 + sum(max(0, d_i - n_i.(x + e))^2) / (2 kCornerSoftness),   result (1 + kCornerSoftness) e
 *
 * The softness keeps it defined where no outside is left (planes that face each other across a gap too small) and the
 * solution unique; one plane, or planes square to each other, are exact. Where an outside is left, the result / (1 +
 * kCornerSoftness) is within sqrt(kCornerSoftness) / 2 |l| of the exact way, l >= 0 being what each plane adds to that
 * (exact = sum(l_i n_i)): 0.16 % of |l|, which is much longer than the way only in a steep groove. Lipschitz: |change
 * of e| <= |change of x|. Newton's method on a piecewise quadratic in three unknowns, each step to the least cost on
 * its line: ends exactly, within kCornerSteps.
 */
[[nodiscard]] Vec3 wayOut(const float (*halfspace)[4], std::uint32_t count, const Vec3& x) HD_RT;

inline constexpr double kCornerSoftness = 1e-5;
inline constexpr int kCornerSteps = 32;

}  // namespace hapticd
