/** @file
 * How strong a device may be now: what the guard holds to, and the order that changes it.
 */
#pragma once

#include "rt/base/contract.h"
#include "rt/command.h"

namespace hapticd {

/** Bounds on what reaches the hand. All >= 0 and finite; zero means none at all. */
struct GuardLimits {
  double force = 0;          ///< [N]
  double torque = 0;         ///< [N m]
  double force_slew = 0;     ///< [N/s], of the gripper too.
  double torque_slew = 0;    ///< [N m/s]
  double gripper_force = 0;  ///< [N]
  double velocity = 0;       ///< Above it the guard latches [m/s].
  double power = 0;          ///< Most power delivered to the hand [W].
  double active_power =
      0;  ///< Budget of active sources (client force, springs, moving bodies, vibrations, transients) [W].
};

/** All are finite and >= 0. Servo-safe. */
[[nodiscard]] bool valid(const GuardLimits& limits) HD_RT;

/** Each the lower of the two; NaN where `a` is NaN. Servo-safe. */
[[nodiscard]] GuardLimits lower(const GuardLimits& a, const GuardLimits& b) HD_RT;

/** What an order wants. Servo-safe. */
[[nodiscard]] GuardLimits limitsOf(const DeviceLimits& order) HD_RT;

/** The order that sets these limits, or, with `only_lowers`, lowers those that are higher. Servo-safe. */
[[nodiscard]] DeviceLimits limitsOrder(std::uint32_t device, const GuardLimits& limits, bool only_lowers) HD_RT;

}  // namespace hapticd
