// What each source counts as: all of it reaches the hand, and each part is booked where it belongs.
#include <gtest/gtest.h>

#include "rt/guard/guard.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

GuardConfig unbound() {
  GuardConfig config = rigConfig();
  config.limits.force = 100;
  config.limits.force_slew = 1e6;
  config.limits.power = config.limits.active_power = 1000;
  return config;
}

/** Those of the guard's sources, by axis; of the texture some is relief, of the local model some is active. */
void askOfAll(GuardRig& rig) {
  rig.ask(HD_SOURCE_SURFACE, {1, 0, 0});
  rig.ask(HD_SOURCE_EFFECT, {0, 2, 0});
  rig.ask(HD_SOURCE_LOCAL_MODEL, {0, 0, 4});
  rig.ask(HD_SOURCE_CLIENT, {8, 0, 0});
  rig.ask(HD_SOURCE_GRAVITY, {0, 16, 0});
  rig.ask(HD_SOURCE_TEXTURE, {0, 0, 32});
  rig.ask(HD_SOURCE_TRANSIENT, {3, 0, 0});
  rig.in.local_active = {0, 5, 1};
  rig.in.relief = {0, 7, 9};
}

TEST(GuardSources, AllOfThemReachTheHandHoweverTheyAreSplit) {
  GuardRig rig(unbound());
  askOfAll(rig);
  rig.armFully();
  rig.step(5);
  EXPECT_LT((rig.out.command.force - Vec3(12, 18, 36)).norm(), 1e-9) << rig.out.command.force.transpose();
}

/** The observer's book: a hand that is moved takes from it what passive sources do, and nothing of the others. */
TEST(GuardSources, OnlyPassiveOnesAreBooked) {
  for (int axis = 0; axis < 3; ++axis) {
    GuardRig rig(unbound());
    askOfAll(rig);
    rig.armFully();
    rig.step(5);
    const double before = rig.out.energy;
    rig.sample.p[axis] += 1e-5;
    rig.step();
    const Vec3 passive = Vec3(1, 0, 0) + Vec3(0, 7, 9) + (Vec3(0, 0, 4) - Vec3(0, 5, 1));
    EXPECT_NEAR(rig.out.energy - before, -1e-5 * passive[axis], 1e-12) << "axis " << axis;
  }
}

TEST(GuardSources, TheRampWaitsForTheirSumButNotForGravity) {
  const auto waits = [](const Vec3& passive, const Vec3& active, const Vec3& gravity) {
    GuardRig rig;
    rig.ask(HD_SOURCE_SURFACE, passive);
    rig.ask(HD_SOURCE_CLIENT, active);
    rig.ask(HD_SOURCE_GRAVITY, gravity);
    rig.step();
    EXPECT_EQ(rig.guard.arm(), ErrorCode::kOk);
    rig.step(10);
    return (rig.out.flags & HD_SAMPLE_WAITING) != 0;
  };
  EXPECT_FALSE(waits({2, 0, 0}, {-2, 0, 0}, {3, 0, 0}));
  EXPECT_TRUE(waits({0.15, 0, 0}, {0.15, 0, 0}, {-0.3, 0, 0}));
}

/** What the limit leaves of all together it leaves of the active ones, whatever the others do. */
TEST(GuardSources, TheBudgetChargesActiveOnesForTheirShareOfWhatIsSent) {
  GuardConfig config = unbound();
  config.passivity = false;
  config.limits.force = 4;
  config.limits.active_power = 1;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_CLIENT, {6, 0, 0});
  rig.ask(HD_SOURCE_SURFACE, {-2, 0, 0});
  rig.ask(HD_SOURCE_GRAVITY, {4, 0, 0});  // 8 N, of which half is sent.
  rig.armFully();
  rig.in.velocity.v = {0.5, 0, 0};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.force.x(), 4 - 0.5 / 0.5, 1e-9) << "3 N of the client's at 0.5 m/s are 1.5 of 1 W";
}

/** A hand that yields at 0.1 m/s to a surface's 2 N; what moves bodies may give 1 W. */
GuardRig pushedAlong() {
  GuardConfig config = unbound();
  config.passivity = false;
  config.limits.active_power = 1;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_SURFACE, {2, 0, 0});
  rig.armFully();
  rig.in.velocity.v = {0.1, 0, 0};
  return rig;
}

/** A body that a client moves in steps, once in 20 ticks, is charged as one that moves steadily. */
TEST(GuardSources, WhatMovesBodiesIsChargedForTheAverage) {
  GuardRig rig = pushedAlong();
  for (int i = 0; i < 2000; ++i) {
    rig.in.carried = {i % 20 == 0 ? 16.0 : 0.0, 0, 0};  // 0.8 W on the average.
    rig.step();
    ASSERT_NEAR(rig.out.command.force.x(), 2, 1e-9) << i;
  }
}

/** A tick longer than the average's time is all of it, and no more. */
TEST(GuardSources, InALongTickWhatMovesBodiesIsChargedOnce) {
  GuardRig rig = pushedAlong();
  rig.in.dt = 2 * Guard::kCarried_s;
  rig.in.velocity.v = {1, 0, 0};
  rig.in.carried = {1.5, 0, 0};
  EXPECT_NEAR(rig.step().command.force.x(), 1.5, 1e-9) << "2 W, of which 1.5 are another's, who may give 1";
}

TEST(GuardSources, TheBudgetChargesSmallForcesToo) {
  for (const double force : {0.9, 1e-3}) {
    GuardConfig config = unbound();
    config.limits.active_power = force / 4;
    GuardRig rig(config);
    rig.ask(HD_SOURCE_CLIENT, {force, 0, 0});
    rig.armFully();
    rig.in.velocity.v = {1, 0, 0};
    rig.step(100);
    EXPECT_NEAR(rig.out.command.force.x(), force / 4, 1e-9);
  }
}

/** A client that only keeps a wall from the hand moves nothing: what torque may give is not less for it. */
TEST(GuardSources, ForcesThatCancelAreNotCharged) {
  GuardConfig config = unbound();
  config.passivity = false;
  config.limits.active_power = 1;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_SURFACE, {-5, 0, 0});
  rig.ask(HD_SOURCE_CLIENT, {5, 0, 0});
  rig.in.source[HD_SOURCE_CLIENT].torque = {0, 0.2, 0};
  rig.armFully();
  rig.in.velocity = {{1, 0, 0}, {0, 4, 0}};
  rig.step(100);
  EXPECT_NEAR(rig.out.command.torque.y(), 0.2, 1e-9) << "0.8 of 1 W";
}

/** Damping of a wall in debt may make what is sent larger than what was asked for; no client has asked for that. */
TEST(GuardSources, WhatDampingAddsIsNotChargedToTheBudget) {
  GuardConfig config = unbound();
  config.energy_limit = 100;
  config.max_damping = 20;
  config.limits.active_power = 0.6;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_SURFACE, {0, 5, 0});
  rig.armFully();
  for (int i = 0; i < 50; ++i) {
    rig.sample.p.y() += 1e-4;  // Pushed along by it: a debt of 0.5 mJ a tick.
    rig.step();
  }
  ASSERT_LT(rig.out.energy, -0.02);
  rig.ask(HD_SOURCE_SURFACE, {0, 0.1, 0});
  rig.ask(HD_SOURCE_CLIENT, {1, 0, 0});
  rig.in.velocity.v = {0.5, -0.1, 0};
  rig.step(2);
  EXPECT_NEAR(rig.out.command.force.y(), 0.1 + 20 * 0.1, 1e-9);
  EXPECT_NEAR(rig.out.command.force.x(), 1, 1e-9) << "0.5 of 0.6 W";
}

/** A wall that a client moves into a hand which yields nearly as fast: all that its spring gains has been paid for. */
TEST(GuardSources, AWallThatIsMovedIntoTheHandLeaksNothing) {
  constexpr double kStiff = 600, kWall = 0.1, kHand = 0.09;
  GuardRig rig(unbound());
  rig.armFully();
  rig.in.velocity.v = {kHand, 0, 0};
  for (int i = 0; i < 200; ++i) {
    const double depth = (kWall - kHand) * 1e-3 * i;
    rig.ask(HD_SOURCE_SURFACE, {kStiff * depth, 0, 0});
    rig.in.stored = 0.5 * kStiff * depth * depth;
    rig.in.carried = {kStiff * depth * kWall, 0, 0};
    rig.sample.p.x() += kHand * 1e-3;
    rig.step();
    ASSERT_EQ(rig.out.flags & HD_SAMPLE_PASSIVITY, 0u) << i;
  }
}

}  // namespace
}  // namespace hapticd
