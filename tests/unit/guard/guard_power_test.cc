// How hard a hand can be thrown: the bounds on power.
#include <gtest/gtest.h>

#include "rt/guard/guard.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

TEST(GuardPower, TheLimitTakesOnlyWhatDeliversPower) {
  GuardRig rig;
  rig.config.passivity = false;
  rig.config.limits.power = 0.5;
  GuardRig r(rig.config);
  r.ask(HD_SOURCE_GRAVITY, {4, 3, 0});
  r.armFully();
  r.step(100);
  r.in.velocity.v = {0.5, 0, 0};
  r.step(100);
  EXPECT_NEAR(r.out.command.force.x(), 1, 1e-9) << "0.5 W at 0.5 m/s";
  EXPECT_NEAR(r.out.command.force.y(), 3, 1e-9) << "across the motion no power flows";
  EXPECT_TRUE(r.out.flags & HD_SAMPLE_LIMITED);
  r.in.velocity.v = {-0.5, 0, 0};
  r.step(100);
  EXPECT_NEAR(r.out.command.force.x(), 4, 1e-9) << "braking is not delivering";
  EXPECT_FALSE(r.out.flags & HD_SAMPLE_LIMITED);
}

TEST(GuardPower, ActiveSourcesHaveTheirOwnBudget) {
  GuardConfig config = rigConfig();
  config.passivity = false;
  config.limits.active_power = 0.25;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_CLIENT, {2, 0, 0});
  rig.armFully();
  rig.in.velocity.v = {0.5, 0, 0};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.force.x(), 0.5, 1e-9);

  for (const hd_source source : {HD_SOURCE_TEXTURE, HD_SOURCE_TRANSIENT}) {
    GuardRig surface(config);
    surface.ask(source, {2, 0, 0});
    surface.armFully();
    surface.in.velocity.v = {0.5, 0, 0};
    surface.step(100);
    EXPECT_NEAR(surface.out.command.force.x(), 0.5, 1e-9) << "source " << source;
    EXPECT_EQ(surface.out.by_source[source].x(), 2) << "it is told who asked";
  }

  GuardRig passive(config);
  passive.ask(HD_SOURCE_SURFACE, {2, 0, 0});
  passive.armFully();
  passive.in.velocity.v = {0.5, 0, 0};
  passive.step(100);
  EXPECT_NEAR(passive.out.command.force.x(), 2, 1e-9) << "a wall that pushes back gives back what it got";

  GuardRig moving(config);
  moving.ask(HD_SOURCE_SURFACE, {2, 0, 0});
  moving.armFully();
  moving.in.velocity.v = {0.5, 0, 0};
  moving.in.carried = {1, 0, 0};  // The wall itself moves at 0.5 m/s.
  moving.step(2000);
  EXPECT_NEAR(moving.out.command.force.x(), 0.5, 1e-9);
}

/** A client that asks for ten times the force that may be sent puts in what is sent. */
TEST(GuardPower, WhatTheForceLimitTakesIsNotChargedToTheBudget) {
  GuardConfig config = rigConfig();
  config.passivity = false;
  config.limits.active_power = 5;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_CLIENT, {80, 0, 0});
  rig.armFully();
  rig.in.velocity.v = {0.5, 0, 0};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.force.x(), 8, 1e-9) << "4 of 5 W";
  rig.in.velocity.v = {1, 0, 0};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.force.x(), 5, 1e-9) << "8 of 5 W";
}

TEST(GuardPower, AHandThatTurnsOnTheSpotIsBoundByItsTorqueAlone) {
  GuardConfig config = rigConfig();
  config.limits.power = 0.5;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_GRAVITY, {2, 0, 0});
  rig.in.source[HD_SOURCE_GRAVITY].torque = {0, 0.2, 0.1};
  rig.armFully();
  rig.in.velocity.w = {0, 5, 0};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.torque.y(), 0.1, 1e-9) << "0.5 W at 5 rad/s";
  EXPECT_NEAR(rig.out.command.torque.z(), 0.1, 1e-9);
  EXPECT_NEAR(rig.out.command.force.x(), 2, 1e-9);
}

/** Of a hand that is pushed on and on by a wall, beyond what a client's limit lets through. */
TEST(GuardPower, WhatIsLimitedAndDampedIsToldAsBoth) {
  GuardRig rig;
  rig.ask(HD_SOURCE_SURFACE, {20, 0, 0});
  rig.armFully();
  rig.in.velocity.v = {0.1, 0, 0};
  for (int i = 0; i < 50; ++i) {
    rig.sample.p.x() += 1e-4;
    rig.step();
  }
  ASSERT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE});
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_PASSIVITY);
  EXPECT_TRUE(rig.out.flags & HD_SAMPLE_LIMITED);
}

/** Squares of such speeds are zero, and nothing may be divided by them. */
TEST(GuardPower, AHandAllButAtRestIsBoundByNoBudget) {
  for (const double speed : {1e-170, 1e-155, 1e-9}) {
    GuardConfig config = rigConfig();
    config.limits.power = config.limits.active_power = 0;
    GuardRig rig(config);
    rig.in.source[HD_SOURCE_CLIENT] = {Vec3(2, 0, 0), Vec3(0, 0.2, 0)};
    rig.armFully();
    rig.in.velocity = {{speed, 0, 0}, {0, speed, 0}};
    rig.step(100);
    EXPECT_EQ(rig.out.fault, std::uint32_t{HD_FAULT_NONE}) << speed;
    EXPECT_NEAR(rig.out.command.force.x(), 2, 1e-9) << speed;
    EXPECT_NEAR(rig.out.command.torque.y(), 0.2, 1e-9) << speed;
  }
}

TEST(GuardPower, WhatAWallPutInBeforeAFaultIsForgotten) {
  GuardConfig config = rigConfig();
  config.passivity = false;
  config.ramp_ns = 1'000'000;
  config.limits.active_power = 0.1;
  GuardRig rig(config);
  rig.armFully();
  rig.ask(HD_SOURCE_SURFACE, {2, 0, 0});
  rig.in.velocity.v = {0.5, 0, 0};
  rig.in.carried = {100, 0, 0};
  rig.step(500);
  EXPECT_NEAR(rig.out.command.force.x(), 0, 1e-9);
  rig.guard.latch(HD_FAULT_STOP_LINE);
  rig.in.carried.setZero();
  rig.armFully();
  rig.step(10);
  EXPECT_NEAR(rig.out.command.force.x(), 2, 1e-9);
}

}  // namespace
}  // namespace hapticd
