/** @file
 * Whoever feeds a guard anything at all, and knows what of that is a fault.
 */
#pragma once

#include <cmath>

#include "rt/guard/guard.h"
#include "tests/support/random.h"

namespace hapticd::test {

inline GuardLimits randomLimits(Random& random) {
  const auto some = [&](double most) { return random.once(12) ? 0.0 : random.in(0, most); };
  GuardLimits l{some(10), some(0.5), some(2000), some(100), some(5), 0.5 + some(2), some(20), some(5)};
  if (random.once(20)) l.force = std::abs(random.wild());
  if (random.once(20)) l.force_slew = std::abs(random.wild());
  if (random.once(20)) l.power = std::abs(random.wild());
  if (random.once(20)) l.velocity = std::abs(random.wild());
  return l;
}

inline GuardConfig randomConfig(Random& random) {
  GuardConfig config;
  config.limits = randomLimits(random);
  config.ramp_ns = static_cast<std::int64_t>(random.in(0, 30e6));
  config.life_ns = random.once(3) ? 0 : std::int64_t{1'000'000} * (1 + random.below(60));
  config.small_force_ticks = 1 + random.below(4);
  config.passivity = !random.once(3);
  config.max_damping = random.in(0, 20);
  config.delay = random.once(10) ? random.wild() : random.in(0, 20);
  config.energy_limit = random.once(2) ? 1e9 : random.in(0.001, 0.3);
  return config;
}

/** A guard fed with whatever comes; cause() and broken() are the test's own account of what must latch. */
struct Adversary {
  Random random;
  GuardConfig config;
  Guard guard;
  DeviceSample sample;
  GuardInput in;
  GuardOutput out;
  std::int64_t last_fresh = 0;
  bool first = true;
  bool calm;                             ///< No causes of faults: the guard stays armed and the rest gets its exercise.
  int let_go = 0, silent = 0, fast = 0;  ///< Ticks that it still lasts.

  Adversary(unsigned seed, bool is_calm) : random(seed), config(randomConfig(random)), guard(config), calm(is_calm) {}

  void draw() {
    in = GuardInput{};
    in.dt = 1e-3;
    sample.fresh = !random.once(4);
    sample.status = random.once(50) ? std::uint32_t{kDeviceSaturated} : std::uint32_t{kDeviceOk};
    sample.p = random.vector(0.001);
    sample.q = Quat::Identity();
    sample.has_velocity = random.once(2);
    sample.v = random.vector(1);
    sample.w = random.vector(1);
    const bool quiet = random.once(2);  // So that small force comes at times.
    for (auto& source : in.source) {
      if (quiet || random.once(2)) continue;
      source.force = random.once(6) ? random.wildVector() : random.vector(random.once(3) ? 30 : 3);
      source.torque = random.once(6) ? random.wildVector() : random.vector(0.5);
    }
    in.velocity.v = random.vector(0.25);
    in.velocity.w = random.vector(3);
    in.local_active = random.vector(quiet ? 0 : 1);
    in.relief = random.once(8) ? random.wildVector() : random.vector(quiet ? 0 : 1);
    in.carried = random.once(8) ? random.wildVector() : random.vector(0.1);
    in.stored = random.wild();
    in.gripper_force = quiet ? 0 : (random.once(6) ? random.wild() : random.in(-5, 5));
    if (random.once(60)) in.missed = random.below(50);
    if (!calm) trouble();
  }

  void trouble() {
    last();
    if (random.once(400)) in.stop_line = true;
    if (random.once(400)) in.deadman_open = true;
    if (random.once(400)) in.missed = random.below(100);
    if (random.once(400)) sample.status |= 1u << random.below(4);
    if (random.once(400)) in.velocity.v = random.wildVector();
    if (random.once(400)) sample.p = random.wildVector();
    if (!random.once(200)) return;
    double* const anything[] = {&in.velocity.v.x(),
                                &in.velocity.w.z(),
                                &in.local_active.y(),
                                &in.relief.z(),
                                &in.carried.x(),
                                &in.gripper_force,
                                &in.dt,
                                &sample.p.y(),
                                &sample.q.x(),
                                &sample.gripper_rad,
                                &sample.v.z(),
                                &sample.w.x(),
                                &in.source[random.below(int{HD_SOURCE_GUARD})].force[random.below(3)],
                                &in.source[random.below(int{HD_SOURCE_GUARD})].torque[random.below(3)]};
    *anything[random.below(static_cast<int>(std::size(anything)))] = random.broken();
  }

  /** Troubles that go on for a while, so that others come on top of them. */
  void last() {
    if (random.once(400)) let_go = random.below(60);
    if (random.once(2000)) silent = random.below(60);
    if (random.once(400)) fast = random.below(60);
    if (let_go-- > 0) in.deadman_open = true;
    if (silent-- > 0) sample.fresh = false;
    if (fast-- > 0) in.velocity.v = {5, 0, 0};
  }

  /** Whether the driver has let go of the force, for the servo was silent. */
  [[nodiscard]] bool takenBack() const {
    return config.life_ns > 0 && (1 + std::int64_t{in.missed}) * 1'000'000 >= config.life_ns;
  }

  /** Whether the input has a cause other than energy. */
  bool cause() {
    if (broken() || in.deadman_open || in.missed >= 50 || (sample.status & kDeviceDeadmanOpen) != 0) return true;
    const double speed = in.velocity.v.norm();  // Of 1e-160 m/s the squares are zero, and that is a rest.
    return speed > guard.limits().velocity || speed > 100;
  }

  /** Whether it has one that latches even while disarmed. */
  bool broken() {
    bool bad = in.stop_line || (sample.status & (kDeviceError | kDeviceGone)) != 0;
    bad = bad || !(in.dt > 0 && in.dt < 1) || !std::isfinite(in.gripper_force + sample.gripper_rad);
    for (int s = 0; s < HD_SOURCE_GUARD; ++s) {
      for (int i = 0; i < 3; ++i) {
        bad = bad || !std::isfinite(in.source[s].force[i]) || !std::isfinite(in.source[s].torque[i]);
      }
    }
    for (int i = 0; i < 3; ++i) {
      bad = bad || !std::isfinite(in.velocity.v[i]) || !std::isfinite(in.velocity.w[i]) || !std::isfinite(sample.p[i]);
      bad = bad || !std::isfinite(in.local_active[i]) || !std::isfinite(in.relief[i]);
      bad = bad || !std::isfinite(in.carried[i]);
    }
    for (int i = 0; i < 4; ++i) bad = bad || !std::isfinite(sample.q.coeffs()[i]);
    if (sample.has_velocity) bad = bad || !std::isfinite(sample.v.sum() + sample.w.sum());
    return bad || in.now_ns - last_fresh > 20'000'000;
  }

  void step(std::int64_t now) {
    in.now_ns = now;
    in.sample = &sample;
    if (sample.fresh || first) last_fresh = now;
    first = false;
    guard.step(in, out);
  }
};

}  // namespace hapticd::test
