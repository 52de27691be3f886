// A servo that was silent for longer than the driver lets a command stand: the hand has felt nothing meanwhile.
#include <gtest/gtest.h>

#include "rt/guard/guard.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

GuardConfig takingBack() {
  GuardConfig config = rigConfig();
  config.life_ns = 10'000'000;
  return config;
}

/** A hand that a wall holds with 6 N; the next tick comes late. */
struct Held {
  GuardRig rig;
  explicit Held(const GuardConfig& config = takingBack()) : rig(config) {
    rig.armFully();
    rig.ask(HD_SOURCE_SURFACE, {6, 0, 0});
    rig.step(100);
  }
  const GuardOutput& late(std::uint32_t missed) {
    rig.in.missed = missed;
    rig.in.now_ns += std::int64_t{missed} * 1'000'000;
    rig.step();
    rig.in.missed = 0;
    return rig.out;
  }
};

TEST(GuardSilence, WhatTheDriverHasTakenBackComesAtTheSlewAgain) {
  for (const std::uint32_t missed : {9u, 10u, 49u}) {
    Held hand;
    ASSERT_NEAR(hand.rig.out.command.force.x(), 6, 1e-9);
    EXPECT_NEAR(hand.late(missed).command.force.x(), 0.5, 1e-9) << missed;
    EXPECT_TRUE(hand.rig.out.command.enabled);
    EXPECT_NEAR(hand.rig.step().command.force.x(), 1, 1e-9);
  }
}

TEST(GuardSilence, AShorterOneTakesNothing) {
  Held hand;
  EXPECT_NEAR(hand.late(8).command.force.x(), 6, 1e-9);
}

TEST(GuardSilence, NorOneOfADeviceThatKeepsWhatItWasSent) {
  Held hand(rigConfig());
  EXPECT_NEAR(hand.late(49).command.force.x(), 6, 1e-9);
}

TEST(GuardSilence, AsTorqueAndGripperDo) {
  Held hand;
  hand.rig.in.source[HD_SOURCE_CLIENT].torque = {0, 0, 0.2};
  hand.rig.in.gripper_force = 3;
  hand.rig.step(100);
  ASSERT_NEAR(hand.rig.out.command.torque.z(), 0.2, 1e-9);
  ASSERT_NEAR(hand.rig.out.command.gripper_force, 3, 1e-9);
  hand.late(10);
  EXPECT_NEAR(hand.rig.out.command.torque.z(), 0.02, 1e-9);
  EXPECT_NEAR(hand.rig.out.command.gripper_force, 0.5, 1e-9);
}

// The hand goes 2 mm into the wall, evenly, in 20 ms; for half of the way it is pushed.
TEST(GuardSilence, OnlyWhatStoodIsBookedAsWork) {
  Held hand;
  hand.rig.in.stored = 1;
  hand.rig.step();
  const double before = hand.rig.out.energy;
  hand.rig.sample.p.x() -= 0.002;
  EXPECT_NEAR(hand.late(19).energy - before, 0.5 * 6 * 0.002, 1e-9);
}

// What a delayed command was to show after the silence is not shown any more.
TEST(GuardSilence, WhatWasOnItsWayIsNoWorkAfterwards) {
  GuardConfig config = takingBack();
  config.delay = 3;
  Held hand(config);
  hand.rig.in.stored = 1;
  hand.rig.step();
  hand.late(19);
  const double before = hand.rig.out.energy;
  hand.rig.sample.p.x() -= 0.001;
  EXPECT_NEAR(hand.rig.step().energy, before, 1e-12);
}

/** The motors rest from when the driver lets go. */
TEST(GuardSilence, NorDoesItHeatTheMotors) {
  const auto heatOf = [](std::int64_t life_ns, std::uint32_t missed) {
    GuardConfig config = rigConfig();
    config.continuous_force = 2;
    config.peak_force = 8;
    config.heating_s = 1;
    config.life_ns = life_ns;
    Held hand(config);
    const double before = hand.rig.guard.heat();
    return hand.late(missed).heat - before;
  };
  const double whole = heatOf(0, 39), taken = heatOf(10'000'000, 39);
  EXPECT_GT(taken, 0);
  EXPECT_NEAR(taken / whole, 9.0 / 40, 0.02);
}

}  // namespace
}  // namespace hapticd
