/** @file
 * The arm of a played WoodenHaptics or Polhem, the other way round than a driver needs it: from the tip to the joints.
 */
#pragma once

#include "rt/base/math.h"

namespace haptic_emu {

using hapticd::Vec3;

/** Which arm. */
enum class WoodyKind : std::uint8_t { kWooden2015, kPolhem3 };

/** Angles of A, B, C with the tip at p from the workspace's origin [rad]; NaN where it does not reach. */
[[nodiscard]] Vec3 woodyJoints(WoodyKind kind, const Vec3& p);
/** Exact encoder counts at those angles. */
[[nodiscard]] Vec3 woodyCounts(WoodyKind kind, const Vec3& joints);
/** Force at the tip [N] of motor currents [A], by virtual work over central differences of the joints. */
[[nodiscard]] Vec3 woodyForce(WoodyKind kind, const Vec3& p, const Vec3& amperes);

}  // namespace haptic_emu
