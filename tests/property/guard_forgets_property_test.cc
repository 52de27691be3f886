// What the guard of a device that has been off remembers of before: nothing that could be felt.
#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

/** A hand in stiff walls that goes as far as `way` in a tick, pushed by clients and by moving bodies. */
void draw(Random& random, GuardRig& rig, double way) {
  rig.sample.p += random.vector(way);
  rig.in.velocity = {random.vector(0.5), random.vector(2)};
  for (Wrench& source : rig.in.source) source = {random.vector(1), random.vector(0.03)};
  rig.ask(HD_SOURCE_SURFACE, random.vector(50));
  rig.in.gripper_force = random.in(-2, 2);
  rig.in.local_active = random.vector(1);
  rig.in.relief = random.vector(0.3);
  rig.in.carried = random.vector(2);
  rig.in.stored = random.once(4) ? -1 : random.in(0, 0.05);
  rig.in.damping = random.in(0, 2);
}

/** Off by a fault, or lowered: armed again it does bit for bit what one does that has never been armed. */
TEST(GuardProperty, ArmedAgainItIsAsNew) {
  forSeeds(100, [](unsigned seed) {
    Random random(seed);
    GuardConfig config = rigConfig();
    config.small_force = config.small_torque = 100;
    config.small_force_ticks = 1;
    config.ramp_ns = random.once(2) ? 0 : 5'000'000;
    config.delay = random.in(0, 3);
    config.energy_limit = 100;
    config.max_damping = 20;
    config.limits.force = config.limits.power = 1000;
    config.limits.force_slew = 1e6;
    config.limits.active_power = random.in(0.1, 1);
    GuardRig before(config), fresh(config);
    for (GuardRig* rig : {&before, &fresh}) {
      rig->in.dt = 0.25e-3;
      rig->guard.setResolution(1e-5);
    }
    before.step();
    ASSERT_EQ(before.guard.arm(), ErrorCode::kOk);
    for (int i = 0; i < 100; ++i) {
      draw(random, before, 2e-4);
      before.step();
    }
    ASSERT_TRUE(before.guard.armed());
    if (random.once(2)) {
      before.guard.latch(HD_FAULT_STOP_LINE);
    } else {
      before.guard.disarm();
      for (int i = 0; i < 5000 && before.guard.armed(); ++i) before.step();
      ASSERT_FALSE(before.guard.armed());
    }
    fresh.sample = before.sample;
    fresh.in = before.in;
    fresh.step();  // It knows where the hand is.
    ASSERT_EQ(before.guard.arm(), ErrorCode::kOk);
    ASSERT_EQ(fresh.guard.arm(), ErrorCode::kOk);
    // Of ways below the encoder's step a buzz is judged over several ticks.
    const double way = random.once(2) ? 2e-4 : 3e-6;
    for (int i = 0; i < 50; ++i) {
      draw(random, before, way);
      fresh.sample = before.sample;
      fresh.in = before.in;
      before.step();
      fresh.step();
      ASSERT_EQ(before.out.command.force, fresh.out.command.force) << i;
      ASSERT_EQ(before.out.command.torque, fresh.out.command.torque) << i;
      ASSERT_EQ(before.out.command.gripper_force, fresh.out.command.gripper_force) << i;
      ASSERT_EQ(before.out.flags, fresh.out.flags) << i;
      ASSERT_EQ(before.out.energy, fresh.out.energy) << i;
      ASSERT_EQ(before.guard.passivity().leak(), fresh.guard.passivity().leak()) << i;
    }
  });
}

}  // namespace
}  // namespace hapticd
