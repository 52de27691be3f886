/** @file
 * Rotations as vectors: axis times angle.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/** Axis times angle, angle in [0, pi]. */
[[nodiscard]] Vec3 rotationVector(const Quat& q) HD_RT;
/** The rotation by |r| about r. */
[[nodiscard]] Quat fromRotationVector(const Vec3& r) HD_RT;

/** The matrix of the cross product: crossMatrix(a) b = a x b. */
[[nodiscard]] inline Mat3 crossMatrix(const Vec3& a) HD_RT {
  Mat3 m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

}  // namespace hapticd
