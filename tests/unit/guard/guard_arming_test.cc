// Off until armed, and how force comes and goes.
#include <gtest/gtest.h>

#include <cmath>

#include "rt/guard/guard.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

/** At 5 N. */
struct Pushing : GuardRig {
  Pushing() {
    ask(HD_SOURCE_SURFACE, {5, 0, 0});
    armFully();
    step(50);
    EXPECT_NEAR(out.command.force.x(), 5, 1e-9);
  }
  /** With a slew limit that by itself lets nothing fall. */
  void disarmWithoutSlew() {
    GuardLimits limits = guard.limits();
    limits.force_slew = 0;
    EXPECT_EQ(guard.setLimits(limits), ErrorCode::kOk);
    guard.disarm();
  }
};

TEST(GuardArming, RampWaitsForSmallForceThenTakesTwoSeconds) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(1000);
  EXPECT_TRUE(rig.out.command.force.isZero(0)) << "three newtons are not small";
  EXPECT_TRUE(rig.out.command.enabled);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_RAMPING);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_WAITING);

  rig.ask(HD_SOURCE_SURFACE, {0.1, 0, 0});
  rig.step(3);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_WAITING);
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  rig.step(100);
  EXPECT_TRUE(rig.out.command.force.isZero(0)) << "three small ticks are one too few";

  rig.ask(HD_SOURCE_SURFACE, {0, 0, 0});
  rig.step(4);
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_WAITING);
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  for (int i = 1; i <= 2000; ++i) {
    rig.step();
    ASSERT_NEAR(rig.out.command.force.x(), 3.0 * i / 2000, 1e-9) << "tick " << i;
  }
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_RAMPING);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_ARMED);
}

TEST(GuardArming, GravityCompensationDoesNotHoldTheRampBack) {
  GuardRig rig;
  rig.ask(HD_SOURCE_GRAVITY, {0, 0, 2});
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(2010);
  EXPECT_NEAR(rig.out.command.force.z(), 2, 1e-9);
}

TEST(GuardArming, DisarmLowersAtTheSlewLimitThenOff) {
  Pushing rig;
  rig.guard.disarm();
  for (int i = 1; i < 10; ++i) {
    rig.step();
    ASSERT_NEAR(rig.out.command.force.x(), 5 - 0.5 * i, 1e-9);
    ASSERT_TRUE(rig.out.command.enabled);
  }
  rig.step(2);  // The slew limit is kept to the safe side of rounding: a few 1e-12 N may be left for one more tick.
  EXPECT_TRUE(rig.out.command.force.isZero(0));
  EXPECT_FALSE(rig.out.command.enabled);
  EXPECT_FALSE(rig.guard.armed());
}

TEST(GuardArming, DisarmEndsInOneSecondEvenWithoutSlew) {
  Pushing rig;
  rig.disarmWithoutSlew();
  rig.step(250);
  EXPECT_NEAR(rig.out.command.force.x(), 5 / std::exp(1), 0.01);
  rig.step(740);
  EXPECT_GT(rig.out.command.force.x(), 0.09);
  rig.step(11);
  EXPECT_TRUE(rig.out.command.force.isZero(0));
  EXPECT_FALSE(rig.guard.armed());
}

TEST(GuardArming, DisarmEndsInOneSecondAlsoOfAServoThatMissesPeriods) {
  Pushing rig;
  rig.disarmWithoutSlew();
  rig.in.missed = 3;
  for (int i = 0; i < 251; ++i) {
    rig.in.now_ns += 3'000'000;
    rig.step();
  }
  EXPECT_TRUE(rig.out.command.force.isZero(0));
  EXPECT_FALSE(rig.guard.armed());
}

TEST(GuardArming, ArmedAgainWhileItLowersItStillEndsInThatSecond) {
  Pushing rig;
  rig.disarmWithoutSlew();
  rig.step(500);
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(490);
  EXPECT_GT(rig.out.command.force.x(), 0.09);
  rig.guard.disarm();
  rig.step(11);
  EXPECT_TRUE(rig.out.command.force.isZero(0));
}

TEST(GuardArming, ALongWaitForSmallForceIsNotTakenOffTheTimeToLower) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(3000);
  rig.armFully();
  rig.step(50);
  rig.guard.disarm();
  rig.step();
  EXPECT_NEAR(rig.out.command.force.x(), 4.5, 1e-9);
}

TEST(GuardArming, DisarmingWhatIsOffDoesNotTurnItOn) {
  GuardRig rig;
  rig.step();
  rig.guard.disarm();
  EXPECT_FALSE(rig.guard.armed());
  rig.step();
  EXPECT_FALSE(rig.out.command.enabled);
  EXPECT_EQ(rig.out.flags, 0u);
}

TEST(GuardArming, ArmedInTheVeryTickOfAFaultItStillStartsFromZero) {
  Pushing rig;
  rig.guard.latch(HD_FAULT_STOP_LINE);
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step();
  EXPECT_TRUE(rig.out.command.force.isZero(0));
}

TEST(GuardArming, ArmingWhatIsArmedChangesNothing) {
  Pushing rig;
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step();
  EXPECT_NEAR(rig.out.command.force.x(), 5, 1e-9);
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_RAMPING);
}

/** All of what arming asks for is asked for each time. */
TEST(GuardArming, ArmedAgainItWaitsAndRampsAnew) {
  GuardRig rig;
  rig.armFully();
  rig.guard.disarm();
  rig.step(5);
  ASSERT_FALSE(rig.guard.armed());
  rig.ask(HD_SOURCE_GRAVITY, {0, 0, 2});
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(3);
  rig.ask(HD_SOURCE_SURFACE, {3, 0, 0});
  rig.step(10);
  EXPECT_TRUE(rig.out.command.force.isZero(0)) << "three small ticks are one too few";
  rig.ask(HD_SOURCE_SURFACE, {0, 0, 0});
  for (int i = 0; i < 10; ++i) {
    rig.step();
    EXPECT_LE(rig.out.command.force.z(), 2 * 10 / 2000.0) << "tick " << i;
  }
  EXPECT_GT(rig.out.command.force.z(), 0);
}

/** Neither may a torque or a gripper's force leap when the ramp begins. */
TEST(GuardArming, TheRampWaitsForSmallTorqueAndGripperForceToo) {
  const auto waits = [](double torque, double gripper) {
    GuardRig rig;
    rig.in.source[HD_SOURCE_SURFACE].torque = {0, torque, 0};
    rig.in.gripper_force = gripper;
    rig.step();
    EXPECT_EQ(rig.guard.arm(), ErrorCode::kOk);
    rig.step(100);
    return (rig.out.flags & HD_SAMPLE_WAITING) != 0;
  };
  EXPECT_FALSE(waits(0.019, 0.19));
  EXPECT_TRUE(waits(0.021, 0));
  EXPECT_TRUE(waits(0, 0.21));
  EXPECT_TRUE(waits(0, -0.21));
}

/** Nothing is asked for any more; what is still sent is to be down before the ramp begins. */
TEST(GuardArming, TheRampWaitsForWhatIsBeingLowered) {
  Pushing rig;
  GuardLimits limits = rig.guard.limits();
  limits.force_slew = 50;
  ASSERT_EQ(rig.guard.setLimits(limits), ErrorCode::kOk);
  rig.guard.disarm();
  rig.ask(HD_SOURCE_SURFACE, Vec3::Zero());
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  for (int i = 0; i < 95; ++i) {
    ASSERT_TRUE(rig.step().flags & HD_SAMPLE_WAITING);
    ASSERT_FALSE(rig.out.command.force.isZero(0));
  }
  rig.step(10);
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_WAITING);
}

/** A torque or a gripper's force too: the second in which they are down at the latest ends with the waiting. */
TEST(GuardArming, TheRampWaitsForATorqueAndAGripperThatAreBeingLowered) {
  for (const bool grips : {false, true}) {
    GuardRig rig;
    rig.armFully();
    if (!grips) rig.in.source[HD_SOURCE_SURFACE].torque = {0, 0.2, 0};
    rig.in.gripper_force = grips ? 2 : 0;
    rig.step(100);
    GuardLimits limits = rig.guard.limits();
    limits.force_slew = limits.torque_slew = 0;
    ASSERT_EQ(rig.guard.setLimits(limits), ErrorCode::kOk);
    rig.guard.disarm();
    rig.in.source = {};
    rig.in.gripper_force = 0;
    rig.step();
    ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
    const auto sent = [&] { return rig.out.command.torque.norm() + rig.out.command.gripper_force; };
    for (int i = 0; i < 990; ++i) {
      ASSERT_TRUE(rig.step().flags & HD_SAMPLE_WAITING) << grips << " " << i;
      ASSERT_GT(sent(), 0.003);
    }
    rig.step(20);
    EXPECT_EQ(sent(), 0);
    EXPECT_FALSE(rig.out.flags & HD_SAMPLE_WAITING);
  }
}

TEST(GuardArming, ToldToArmInEveryTickItRampsAllTheSame) {
  GuardRig rig;
  rig.step();
  for (std::uint32_t i = 0; i < rig.config.small_force_ticks; ++i) {
    ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
    rig.step();
  }
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_WAITING);
}

/** Torque and gripper keep to their slew to the end, and the amplifiers are on as long. */
TEST(GuardArming, WhatIsLoweredLastIsLoweredAsSlowly) {
  for (const bool turns : {true, false}) {
    GuardRig rig;
    rig.armFully();
    GuardLimits limits = rig.guard.limits();
    limits.torque_slew = 2;
    if (!turns) limits.force_slew = 20;
    ASSERT_EQ(rig.guard.setLimits(limits), ErrorCode::kOk);
    if (turns) rig.in.source[HD_SOURCE_CLIENT].torque = {0.2, 0, 0};
    if (!turns) rig.in.gripper_force = -2;
    rig.step(200);
    rig.guard.disarm();
    for (int i = 1; i < 100; ++i) {
      rig.step();
      ASSERT_NEAR(turns ? rig.out.command.torque.x() : -0.1 * rig.out.command.gripper_force, 0.2 - 0.002 * i, 1e-9);
      ASSERT_TRUE(rig.out.command.enabled);
      ASSERT_FALSE(rig.out.flags & HD_SAMPLE_RAMPING);
    }
    rig.step(2);
    EXPECT_FALSE(rig.out.command.enabled);
  }
}

TEST(GuardArming, DisarmedInTheMiddleOfTheRampItRampsNoMore) {
  GuardRig rig;
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step(4);
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.step(1000);
  ASSERT_TRUE(rig.out.flags & HD_SAMPLE_RAMPING);
  rig.guard.disarm();
  rig.step();
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_ARMED);
  EXPECT_FALSE(rig.out.flags & HD_SAMPLE_RAMPING);
}

}  // namespace
}  // namespace hapticd
