/** @file
 * Where a device stands, as people say it: a place, and three turns in degrees.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/** Turned about the world's x, then its y, then its z (roll, pitch, yaw) [deg]. */
[[nodiscard]] Quat fromDegrees(const Vec3& degrees);
/** Those turns; about x none where y is turned by 90 degrees, which leaves a choice [deg]. */
[[nodiscard]] Vec3 toDegrees(const Quat& q);

}  // namespace hapticd
