/** @file
 * A guard with a still, healthy device: tests change what they are about.
 */
#pragma once

#include "rt/guard/guard.h"

namespace hapticd {

inline GuardConfig rigConfig() {
  GuardConfig config;
  config.limits = {.force = 8,
                   .torque = 0.3,
                   .force_slew = 500,
                   .torque_slew = 20,
                   .gripper_force = 4,
                   .velocity = 2,
                   .power = 50,
                   .active_power = 50};
  return config;
}

struct GuardRig {
  GuardConfig config;
  Guard guard;
  DeviceSample sample;
  GuardInput in;
  GuardOutput out;

  explicit GuardRig(const GuardConfig& c = rigConfig()) : config(c), guard(c) {
    sample.fresh = true;
    in.dt = 1e-3;
  }
  const GuardOutput& step() {
    in.sample = &sample;
    in.now_ns += 1'000'000;
    sample.t_ns = in.now_ns;
    guard.step(in, out);
    return out;
  }
  void step(int ticks) {
    for (int i = 0; i < ticks; ++i) step();
  }
  /** Force asked for by one source, nothing else. */
  void ask(hd_source source, const Vec3& force) { in.source[source].force = force; }
  /** Through small force and ramp, with whatever is asked for set aside meanwhile. */
  void armFully() {
    const auto asked = in.source;
    const Vec3 springs = in.local_active;
    in.source = {};
    in.local_active.setZero();
    step();
    (void)guard.arm();
    step(static_cast<int>(config.small_force_ticks + config.ramp_ns / 1'000'000 + 2));
    in.source = asked;
    in.local_active = springs;
  }
};

}  // namespace hapticd
