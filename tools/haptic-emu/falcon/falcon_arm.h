/** @file
 * The legs of a played Falcon, in its own frame (x right, y up, z toward the operator, metres). Nothing here is the
 * driver's: angles by the law of cosines, the force by differences.
 */
#pragma once

#include <array>

#include "rt/base/math.h"

namespace haptic_emu {

using hapticd::Vec3;

/** Encoder counts at p; NaN where a leg does not reach. */
[[nodiscard]] Vec3 falconCounts(const Vec3& p);
/** Force at the grip [N] of motor counts, by virtual work over central differences of the angles. */
[[nodiscard]] Vec3 falconForce(const Vec3& p, const std::array<std::int16_t, 3>& motor);

}  // namespace haptic_emu
