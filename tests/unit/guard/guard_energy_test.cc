// What the guard tells the observer of a hand at rest, and forgets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/guard/guard.h"
#include "tests/unit/guard/guard_rig.h"

namespace hapticd {
namespace {

constexpr double kPush = 30, kSpring = 600, kStored = kPush * kPush / (2 * kSpring);

GuardConfig strong(double force_limit) {
  GuardConfig config = rigConfig();
  config.limits.force = force_limit;
  config.limits.force_slew = 1e6;
  config.limits.power = config.limits.active_power = 1000;
  return config;
}

/** A hand that rests in a wall while the ramp rises. */
struct Resting {
  GuardRig rig;
  explicit Resting(double force_limit) : rig(strong(force_limit)) {
    rig.step();
    (void)rig.guard.arm();
    rig.step(static_cast<int>(rig.config.small_force_ticks));
    rig.ask(HD_SOURCE_SURFACE, {kPush, 0, 0});
    rig.in.stored = kStored;
  }
};

// At the part r of its ramp a wall gives r F all the way out: r times what it holds.
TEST(GuardEnergy, TheRampGivesTheStoreItsPart) {
  Resting hand(100);
  hand.rig.step(1000);
  EXPECT_NEAR(hand.rig.out.command.force.x(), kPush / 2, 1e-9);
  EXPECT_NEAR(hand.rig.out.energy, kStored / 2, 2e-3 * kStored);
  hand.rig.step(1000);
  EXPECT_NEAR(hand.rig.out.energy, kStored, 2e-3 * kStored);
}

// Bound to a third of F, it gives L = F / 3 from depth F / k to L / k, and the spring's force from there:
// (F - L) L / k + L^2 / 2 k = b (2 - b) F^2 / 2 k with b = L / F.
TEST(GuardEnergy, OfAWallThatTheLimitBindsWhatItCanGive) {
  Resting hand(kPush / 3);
  hand.rig.step(1000);
  EXPECT_NEAR(hand.rig.out.command.force.x(), kPush / 6, 1e-9);
  EXPECT_NEAR(hand.rig.out.energy, 5.0 / 9.0 * kStored / 2, 2e-3 * kStored);
}

// A force that falls slower than what is asked for is more than the ramp's part; the store gives no more than its own.
TEST(GuardEnergy, WhileTheSlewHoldsMoreThanTheRampsPartTheStoreGivesThat) {
  Resting hand(100);
  hand.rig.step(1000);
  GuardLimits slow = hand.rig.config.limits;
  slow.force_slew = 100;
  ASSERT_EQ(hand.rig.guard.setLimits(slow), ErrorCode::kOk);
  hand.rig.ask(HD_SOURCE_SURFACE, {kPush / 2, 0, 0});
  const double before = hand.rig.step().energy;
  ASSERT_GT(hand.rig.out.command.force.x(), 1.5 * kPush / 4);
  EXPECT_NEAR(hand.rig.step().energy - before, kStored / 2000, 1e-9);
}

TEST(GuardEnergy, NothingIsGivenWhenTheRampIsThrough) {
  Resting hand(100);
  hand.rig.step(2010);
  const double energy = hand.rig.out.energy;
  hand.rig.in.stored = -1;  // Unknown: it bounds nothing.
  hand.rig.step(100);
  EXPECT_EQ(hand.rig.out.energy, energy);
}

TEST(GuardEnergy, NorWhileTheForceIsLowered) {
  Resting hand(100);
  hand.rig.step(1000);
  GuardLimits slow = hand.rig.config.limits;
  slow.force_slew = 30;
  ASSERT_EQ(hand.rig.guard.setLimits(slow), ErrorCode::kOk);
  const double energy = hand.rig.out.energy;
  hand.rig.guard.disarm();
  hand.rig.step(200);
  ASSERT_GT(hand.rig.out.command.force.x(), 1);
  EXPECT_NEAR(hand.rig.out.energy, energy, 2e-3 * kStored);
}

TEST(GuardEnergy, NorAfterAFault) {
  Resting hand(100);
  hand.rig.step(1000);
  hand.rig.in.stop_line = true;
  hand.rig.step();
  hand.rig.in.stop_line = false;
  hand.rig.step();
  ASSERT_EQ(hand.rig.guard.arm(), ErrorCode::kOk);
  hand.rig.step();
  EXPECT_EQ(hand.rig.out.energy, 0);
}

/** Whatever a world of unknown store has got, it is gone with the contact. */
TEST(GuardEnergy, InFreeSpaceNothingIsStored) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(5);
  for (int i = 0; i < 50; ++i) {
    rig.sample.p.x() -= 1e-3;
    rig.step();
  }
  ASSERT_GT(rig.out.energy, 0.2);
  rig.ask(HD_SOURCE_SURFACE, Vec3::Zero());
  rig.step(2);
  EXPECT_LE(rig.out.energy, Passivity::kMargin * (1 + 1e-9));
}

/** A spring whose force damping takes just now has not lost what it holds: a rounding of that force decides nothing. */
TEST(GuardEnergy, WhatDampingHoldsBackIsStoredStill) {
  for (const double force : {0.0, 1e-15}) {
    GuardRig rig(strong(100));
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.in.stored = 0.05;
    rig.armFully();
    rig.step(5);
    for (int i = 0; i < 50; ++i) {
      rig.sample.p.x() -= 1e-3;
      rig.step();
    }
    const double margin = Passivity::kMargin;
    ASSERT_NEAR(rig.out.energy, 0.05 + margin, 1e-12);
    rig.ask(HD_SOURCE_SURFACE, {force, 0, 0});
    rig.step(2);
    EXPECT_NEAR(rig.out.energy, 0.05 + margin, 1e-12) << force;
  }
}

TEST(GuardEnergy, ADebtOutlivesWhoArmsAgainWhileTheForceIsLowered) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(5);
  for (int i = 0; i < 10; ++i) {
    rig.sample.p.x() += 1e-3;
    rig.step();
  }
  ASSERT_LT(rig.out.energy, -0.03);
  GuardLimits slow = rig.config.limits;
  slow.force_slew = 10;
  ASSERT_EQ(rig.guard.setLimits(slow), ErrorCode::kOk);
  rig.guard.disarm();
  rig.step();
  ASSERT_TRUE(rig.out.command.enabled);
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  rig.step();
  EXPECT_LT(rig.out.energy, -0.03);
}

/** A wall that pushes the hand along does its work, and has been paid for it by who moves it. */
TEST(GuardEnergy, AWallThatCarriesTheHandAlongLeavesTheBooksAsTheyWere) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(5);
  rig.in.carried = {5 * 0.1, 0, 0};  // It moves at 0.1 m/s.
  rig.in.velocity.v = {0.1, 0, 0};
  rig.step();
  for (int i = 0; i < 500; ++i) {
    rig.sample.p.x() += 1e-4;
    rig.step();
    ASSERT_NEAR(rig.out.energy, 0, 1e-9);
  }
}

/** Also where that does far more along one axis and takes as much back along another: a press on what is held. */
TEST(GuardEnergy, WhatIsCarriedCountsByItsSumHoweverLargeItsPartsAre) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(5);
  rig.in.carried = {8000 + 5 * 0.1, -3000, -5000};
  rig.in.velocity.v = {0.1, 0, 0};
  rig.step();
  for (int i = 0; i < 500; ++i) {
    rig.sample.p.x() += 1e-4;
    rig.step();
    ASSERT_NEAR(rig.out.energy, 0, 1e-6) << i;
    ASSERT_EQ(rig.out.flags & HD_SAMPLE_PASSIVITY, 0u);
  }
}

/** It has been paid for through the periods that the servo misses, too. */
TEST(GuardEnergy, ThroughMissedPeriodsAsWell) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.step(5);
  rig.in.carried = {5 * 0.1, 0, 0};
  rig.in.velocity.v = {0.1, 0, 0};
  rig.step();
  for (std::uint32_t i = 0; i < 2000; ++i) {
    rig.in.missed = i % 4;
    rig.in.now_ns += std::int64_t{rig.in.missed} * 1'000'000;
    rig.sample.p.x() += 1e-4 * (1 + rig.in.missed);
    rig.step();
    ASSERT_NEAR(rig.out.energy, 0, 1e-9);
    ASSERT_EQ(rig.out.flags & HD_SAMPLE_PASSIVITY, 0u);
  }
}

/** A leak is repaid by damping at the hand's speed, which periods that are missed do not change. */
TEST(GuardEnergy, MissedPeriodsAreNoHaste) {
  const auto lessAfter = [](std::uint32_t missed) {
    constexpr double kSpeed = 0.1, kStiff = 600;
    GuardRig rig(strong(100));
    rig.armFully();
    rig.in.velocity.v = {kSpeed, 0, 0};
    double push = 0;
    const auto tick = [&] {  // Pushed along, for which somebody pays; not for what the spring gains.
      rig.ask(HD_SOURCE_SURFACE, {push, 0, 0});
      rig.in.stored = push * push / (2 * kStiff);
      rig.in.carried = {push * kSpeed, 0, 0};
      rig.in.now_ns += std::int64_t{rig.in.missed} * 1'000'000;
      rig.sample.p.x() += kSpeed * 1e-3 * (1 + rig.in.missed);
      rig.step();
    };
    for (; push < 2; push += 2.0 / 300) tick();
    rig.in.missed = missed;
    tick();
    EXPECT_TRUE(rig.out.flags & HD_SAMPLE_PASSIVITY);
    return push - rig.out.command.force.x();
  };
  const double steady = lessAfter(0);
  EXPECT_GT(steady, 0.02);
  for (const std::uint32_t missed : {1u, 3u}) EXPECT_NEAR(lessAfter(missed), steady, 0.3 * steady) << missed;
}

/** The force of before a fault, or of before the device was off, is not the force over the first way after. */
TEST(GuardEnergy, WhatActedBeforeItWasOffIsForgotten) {
  for (const bool fault : {true, false}) {
    GuardConfig config = strong(100);
    config.delay = fault ? 0 : 3;
    GuardRig rig(config);
    rig.ask(HD_SOURCE_SURFACE, {20, 0, 0});
    rig.in.carried = {5, 0, 0};
    rig.armFully();
    rig.step(50);
    ASSERT_NEAR(rig.out.command.force.x(), 20, 1e-9);
    if (fault) {
      rig.guard.latch(HD_FAULT_STOP_LINE);
    } else {
      rig.guard.disarm();
    }
    rig.in.source = {};
    rig.in.carried.setZero();
    rig.step(20);
    ASSERT_FALSE(rig.guard.armed());
    ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
    for (int i = 0; i < 5; ++i) {
      rig.sample.p.x() += 1e-3;
      rig.step();
      EXPECT_EQ(rig.out.energy, 0) << (fault ? "fault" : "disarmed");
    }
  }
}

/** And not in the same tick either: a stop and an arming that come together. */
TEST(GuardEnergy, NorWhenArmedAgainInTheSameTick) {
  GuardConfig config = strong(100);
  config.delay = 2;
  GuardRig rig(config);
  rig.ask(HD_SOURCE_SURFACE, {20, 0, 0});
  rig.in.carried = {5, 0, 0};
  rig.armFully();
  rig.step(50);
  rig.guard.latch(HD_FAULT_STOP_LINE);
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  for (int i = 0; i < 5; ++i) {
    rig.sample.p.x() += 1e-3;
    rig.step();
    EXPECT_EQ(rig.out.energy, 0);
  }
}

/** A surface that damps by more than guard and surface may together leaves the guard none: also no negative damping. */
TEST(GuardEnergy, AWellDampedSurfaceLeavesTheControllerNothing) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.armFully();
  rig.in.damping = 10 * rig.config.max_damping;
  rig.in.velocity.v = {0.1, 0, 0};
  for (int i = 0; i < 50; ++i) {
    rig.sample.p.x() += 1e-4;  // Pushed along by it: a debt of 0.5 mJ a tick.
    rig.step();
  }
  ASSERT_LT(rig.out.energy, -0.02);
  EXPECT_NEAR(rig.out.command.force.x(), 5, 1e-9);
  rig.in.damping = 0;
  rig.step();
  EXPECT_LT(rig.out.command.force.x(), 4.9);
}

/** What the slew leaves of a force that nobody asks for any more is the guard's to answer for. */
TEST(GuardEnergy, WhatTheSlewLeavesCountsAsPassive) {
  for (const double now : {1.0, -1.0}) {  // Half of what it was, or the other way.
    GuardRig rig(strong(100));
    rig.ask(HD_SOURCE_CLIENT, {4, 0, 0});
    rig.armFully();
    rig.step(50);
    GuardLimits limits = rig.guard.limits();
    limits.force_slew = 10;
    ASSERT_EQ(rig.guard.setLimits(limits), ErrorCode::kOk);
    rig.ask(HD_SOURCE_CLIENT, {now, 0, 0});
    rig.step();
    for (int i = 0; i < 10; ++i) {
      const double left = rig.out.command.force.x() - std::max(0.0, now), before = rig.out.energy;
      rig.sample.p.x() -= 1e-5;
      rig.step();
      EXPECT_NEAR(rig.out.energy - before, 1e-5 * left, 1e-12) << now;
    }
  }
}

TEST(GuardEnergy, WhoWatchesNoPassivityHasNoFaultOfIt) {
  for (const bool watched : {true, false}) {
    GuardConfig config = strong(100);
    config.passivity = watched;
    config.max_damping = 0;
    GuardRig rig(config);
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.armFully();
    for (int i = 0; i < 100; ++i) {
      rig.sample.p.x() += 1e-3;
      rig.step();
    }
    EXPECT_EQ(rig.out.fault, std::uint32_t{watched ? HD_FAULT_ENERGY : HD_FAULT_NONE});
    EXPECT_EQ(rig.out.energy == 0, watched) << "after a fault the books are empty";
  }
}

/** A metre within a tick is no motion of a hand, whichever way. */
TEST(GuardEnergy, AReadingThatLeapsDoesNoWork) {
  for (const double leap : {0.9, 1.1, -0.9, -1.1}) {
    for (int axis = 0; axis < 3; ++axis) {
      GuardConfig config = strong(100);
      config.energy_limit = 100;
      GuardRig rig(config);
      rig.ask(HD_SOURCE_SURFACE, 5 * Vec3::Unit(axis));
      rig.armFully();
      rig.step(5);
      const double before = rig.out.energy;
      rig.sample.p[axis] += leap;
      rig.step();
      const double work = std::abs(leap) < 1 ? -5 * leap : 0;
      EXPECT_NEAR(rig.out.energy, std::min(before + work, Passivity::kMaxStored + Passivity::kMargin), 1e-9) << leap;
    }
  }
}

/** What a wall held before a fault tells nothing of what it gains in the first tick after. */
TEST(GuardEnergy, WhatWasStoredBeforeAFaultIsNoPartOfALeak) {
  for (const double held : {0.0, 0.03}) {
    GuardRig rig(strong(100));
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.in.stored = held;
    rig.armFully();
    rig.step(5);
    rig.guard.latch(HD_FAULT_STOP_LINE);
    ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
    rig.in.stored = 0.05;
    rig.sample.p.x() -= 1e-3;
    rig.step();
    EXPECT_EQ(rig.guard.passivity().leak(), 0) << held;
  }
}

/** Of 10 mJ it gives 10.3 on the way out: the tick in which the contact ends is booked like any other. */
TEST(GuardEnergy, ASpringThatIsLetGoOfLeaksToTheLastTick) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.in.stored = 0.01;
  rig.armFully();
  rig.step(5);
  ASSERT_EQ(rig.guard.passivity().leak(), 0);
  rig.ask(HD_SOURCE_SURFACE, Vec3::Zero());
  rig.in.stored = 0;
  rig.sample.p.x() += 2.06e-3;
  rig.step();
  EXPECT_NEAR(rig.guard.passivity().leak(), 5 * 2.06e-3 - 0.01, 1e-12);
}

/** As of a surface that only damps: what it takes is gone. */
TEST(GuardEnergy, AContactThatHoldsNothingGivesNothingBack) {
  GuardRig rig(strong(100));
  rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
  rig.in.stored = 0;
  rig.armFully();
  rig.step(5);
  for (int i = 0; i < 50; ++i) {
    rig.sample.p.x() -= 1e-3;
    rig.step();
    ASSERT_LE(rig.out.energy, Passivity::kMargin * (1 + 1e-9)) << i;
  }
}

/** What is no delay is none, and beyond sixteen ticks it is sixteen. */
TEST(GuardEnergy, ADelayThatIsNoneCountsAsNone) {
  const auto energyAt = [](double delay) {
    GuardConfig config = strong(100);
    config.delay = delay;
    GuardRig rig(config);
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.armFully();
    rig.step(10);
    rig.sample.p.x() -= 1e-3;
    rig.step();
    return rig.out.energy;
  };
  ASSERT_NEAR(energyAt(0), 5e-3, 1e-12);
  ASSERT_EQ(energyAt(16), 0) << "the force is younger than that";
  for (const double none : {-1.0, -1e300, double{-INFINITY}, double{NAN}})
    EXPECT_EQ(energyAt(none), energyAt(0)) << none;
  for (const double most : {17.0, 1e300, double{INFINITY}}) EXPECT_EQ(energyAt(most), energyAt(16)) << most;
}

/** A wall and a client that cancel each other: while the ramp has not begun, or is over, no part of it is sent. */
TEST(GuardEnergy, OfForcesThatCancelNoneIsBookedBeforeTheRampAndAfter) {
  GuardConfig config = strong(100);
  config.small_force_ticks = 50;
  GuardRig rig(config);
  const auto cancel = [&] {
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.ask(HD_SOURCE_CLIENT, {-5, 0, 0});
  };
  const auto booksNothing = [&](std::uint32_t flag) {
    const double before = rig.out.energy;
    for (int i = 0; i < 10; ++i) {
      rig.sample.p.x() -= 1e-3;
      rig.step();
      EXPECT_EQ(rig.out.flags & flag, flag) << i;
      EXPECT_EQ(rig.out.energy, before) << i;
    }
  };
  cancel();
  rig.step();
  ASSERT_EQ(rig.guard.arm(), ErrorCode::kOk);
  booksNothing(HD_SAMPLE_WAITING);
  rig.armFully();
  rig.in.source[HD_SOURCE_CLIENT].torque = {0.2, 0, 0};  // It keeps the device on while it is lowered.
  rig.step(100);
  GuardLimits slow = rig.guard.limits();
  slow.torque_slew = 1;
  ASSERT_EQ(rig.guard.setLimits(slow), ErrorCode::kOk);
  rig.guard.disarm();
  rig.step();
  booksNothing(HD_SAMPLE_ARMED);
}

/** Surface and controller together: half as much again as the device can show, and no more than that alone. */
TEST(GuardEnergy, TheControllerAddsWhatTheSurfaceLeavesIt) {
  const double most = rigConfig().max_damping;
  for (const double damping : {0.0, 0.4 * most, 0.6 * most, 1.1 * most, 1.3 * most}) {
    GuardConfig config = strong(100);
    config.energy_limit = 100;
    GuardRig rig(config);
    rig.ask(HD_SOURCE_SURFACE, {5, 0, 0});
    rig.armFully();
    rig.in.damping = damping;
    rig.in.velocity.v = {0.1, 0, 0};
    for (int i = 0; i < 200; ++i) {
      rig.sample.p.x() += 1e-4;
      rig.step();
    }
    ASSERT_LT(rig.out.energy, -0.05);
    EXPECT_NEAR((5 - rig.out.command.force.x()) / 0.1, std::min(most, 1.5 * most - damping), 1e-6) << damping;
  }
}

}  // namespace
}  // namespace hapticd
