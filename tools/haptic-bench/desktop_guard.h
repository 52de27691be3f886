/** @file
 * The guard of a servo that is timed.
 */
#pragma once

#include "rt/guard/guard.h"

namespace haptic_bench {

/** A desktop device's limits, with a ramp that is soon over. */
[[nodiscard]] inline hapticd::GuardConfig desktopGuard() {
  hapticd::GuardConfig guard;
  guard.limits = {.force = 8,
                  .torque = 1,
                  .force_slew = 1e5,
                  .torque_slew = 1e3,
                  .gripper_force = 1,
                  .velocity = 5,
                  .power = 50,
                  .active_power = 20};
  guard.ramp_ns = 10'000'000;
  return guard;
}

}  // namespace haptic_bench
