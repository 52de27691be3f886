/** @file
 * Where the tip of a WoodenHaptics or Polhem arm is, how it moves with the bodies, and what its links weigh there.
 *
 * Frame: base, x outward from it (toward the operator), z up, y by the right hand: hapticd's own. Pure, real-time safe.
 */
#pragma once

#include <array>
#include <cstdint>

#include "drivers/woodyhid/woody_model.h"
#include "rt/base/math.h"

namespace hapticd {

/** The arm in one pose. */
struct WoodyArm {
  Vec3 p = Vec3::Zero();               ///< Tip, from the workspace's origin [m].
  Mat3 jacobian = Mat3::Zero();        ///< d p / d(angles of A, B, C) [m/rad].
  Vec3 gravity_torque = Vec3::Zero();  ///< What on A, B, C carries the links [N m].
  double pitch = 0;                    ///< Of the forearm above the horizontal [rad].
  bool reachable = false;              ///< False: the bars cannot close at such angles; the rest is zero then.
};

/** Angles of the bodies A, B, C from the motors' counters [rad]. */
[[nodiscard]] Vec3 woodyAngles(const WoodyModel& model, const std::array<std::int32_t, 6>& encoder) HD_RT;

/**
 * Serial: B from the vertical, C likewise but hanging, both held by their own motor, so neither turns the other.
 * Five-bar: both from the horizontal.
 */
[[nodiscard]] WoodyArm solveWoodyArm(const WoodyModel& model, const Vec3& angles) HD_RT;

/** Orientation of the stylus: Rz(A) Ry(-pitch) Rx(D) Ry(E) Rx(F), with the gimbal's encoders D, E, F. */
[[nodiscard]] Quat woodyOrientation(const WoodyModel& model, const Vec3& angles, double pitch,
                                    const std::array<std::int32_t, 6>& encoder) HD_RT;

/**
 * The force at the tip that does to the bodies what `torque` does, at most `limit` newtons: near the poses in which the
 * arm cannot push some way it would have no bound.
 */
[[nodiscard]] Vec3 forceForTorque(const WoodyArm& arm, const Vec3& torque, double limit) HD_RT;

/** Motor currents for a force at the tip. */
struct WoodyCurrents {
  std::array<std::int16_t, 3> mA{};
  bool saturated = false;
};
/** All three are scaled together to at most `limit_A`, so that the force keeps its direction. Zero if not finite. */
[[nodiscard]] WoodyCurrents woodyCurrents(const WoodyModel& model, const WoodyArm& arm, const Vec3& force,
                                          double limit_A) HD_RT;

}  // namespace hapticd
