/** @file
 * Whether numbers can be an inertia.
 */
#pragma once

namespace hapticd {

/** Of xx, yy, zz, xy, yz and zx, as in hd_volume_mass: positive definite. */
[[nodiscard]] inline bool isPositiveDefinite(const double (&inertia)[6]) {
  const double xx = inertia[0], yy = inertia[1], zz = inertia[2], xy = inertia[3], yz = inertia[4], zx = inertia[5];
  const double minor = xx * yy - xy * xy;
  const double determinant = zz * minor - xx * yz * yz - yy * zx * zx + 2 * xy * yz * zx;
  return xx > 0 && minor > 0 && determinant > 0;
}

}  // namespace hapticd
