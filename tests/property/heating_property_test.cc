// The motor heating estimate: closed forms, and its promises under any force whatever.
#include <gtest/gtest.h>

#include "rt/guard/guard.h"
#include "rt/guard/heating.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr double kHeatDt = 1e-3;

/** A constant force below derating warms as 1 - exp(-t / tau). */
TEST(Heating, FollowsTheExponential) {
  Heating heating(4, 10, 30);
  for (int i = 0; i < 20'000; ++i) heating.book(3, kHeatDt);
  EXPECT_NEAR(heating.heat(), 9.0 / 16 * (1 - std::exp(-20.0 / 30)), 1e-4);
  for (int i = 0; i < 60'000; ++i) heating.book(0, kHeatDt);
  EXPECT_NEAR(heating.heat(), 9.0 / 16 * (1 - std::exp(-20.0 / 30)) * std::exp(-2.0), 1e-4);
}

/** Peak force lasts tau ln(r^2 / (r^2 - h)) until derating begins, r = peak / continuous, and is announced before. */
TEST(Heating, PeakLastsAsLongAsItShouldAndIsAnnouncedBefore) {
  Heating heating(3, 9, 30);
  double announced = -1;
  double derated = -1;
  for (int i = 0; derated < 0; ++i) {
    if (heating.allowed() < 9) derated = i * kHeatDt;
    if (heating.warm() && announced < 0) announced = i * kHeatDt;
    heating.book(9, kHeatDt);
  }
  EXPECT_NEAR(announced, 30 * std::log(9 / (9 - Heating::kAnnounce)), 2e-2);
  EXPECT_NEAR(derated, 30 * std::log(9 / (9 - Heating::kDerate)), 2e-2);
}

TEST(Heating, ContinuousForceIsNeverCutAndNothingIsWithoutAModel) {
  Heating heating(3, 9, 5);
  for (int i = 0; i < 100'000; ++i) {
    heating.book(3, kHeatDt);
    ASSERT_GE(heating.allowed(), 3);
  }
  EXPECT_NEAR(heating.heat(), 1, 1e-6);
  for (const Heating& none :
       {Heating(0, 9, 30), Heating(3, 3, 30), Heating(3, 9, 0), Heating(NAN, 9, 30), Heating(3, INFINITY, 1)}) {
    EXPECT_TRUE(std::isinf(none.allowed()));
  }
}

TEST(Heating, WhatIsNoModelIsNoneHoweverMuchIsBooked) {
  for (Heating none : {Heating(0, 9, 30), Heating(-1, 9, 30), Heating(3, 3, 30), Heating(3, 2, 30), Heating(3, 9, 0),
                       Heating(3, 9, -1), Heating(NAN, 9, 30), Heating(3, NAN, 30), Heating(3, 9, NAN),
                       Heating(3, INFINITY, 1), Heating(3, 9, INFINITY, 0.95), Heating(INFINITY, INFINITY, 1)}) {
    for (int i = 0; i < 100; ++i) none.book(9, 100);
    EXPECT_EQ(none.heat(), 0);
    EXPECT_TRUE(std::isinf(none.allowed()));
    EXPECT_FALSE(none.warm());
  }
}

/** Of a stylus that stands less than a newton for ever, and warms in less than a second. */
TEST(Heating, SmallMotorsWarmAsLargeOnesDo) {
  for (const double continuous : {0.01, 0.4, 40.0}) {
    for (const double tau : {0.1, 0.7, 70.0}) {
      Heating heating(continuous, 3 * continuous, tau);
      for (int i = 0; i < 1000; ++i) heating.book(0.5 * continuous, 1e-3 * tau);
      EXPECT_NEAR(heating.heat(), 0.25 * (1 - std::exp(-1)), 1e-3) << continuous << " " << tau;
      for (int i = 0; i < 1000; ++i) heating.book(3 * continuous, 1e-3 * tau);
      EXPECT_DOUBLE_EQ(heating.allowed(), continuous);
    }
  }
}

/** Of the daemon that had the device before; what is no heat is taken for the most. */
TEST(Heating, BeginsAtTheHeatThatItIsTold) {
  for (const double heat : {0.0, 0.3, 0.95, 1.0}) EXPECT_EQ(Heating(3, 9, 30, heat).heat(), heat);
  for (const double heat : {-0.1, 1.1, double{NAN}}) EXPECT_EQ(Heating(3, 9, 30, heat).heat(), 1) << heat;
}

TEST(Heating, DeratesFromThePeakToTheContinuousForce) {
  for (const double over : {0.01, 0.25, 0.9, 1.0}) {
    const Heating heating(3, 9, 30, Heating::kDerate + over * (1 - Heating::kDerate));
    EXPECT_NEAR(heating.allowed(), 9 - over * 6, 1e-9);
  }
  EXPECT_TRUE(std::isinf(Heating(3, 9, 30, 0.8).allowed()));
}

/** Periods that are missed may heat beyond what a tick allows for. */
TEST(Heating, LeavesTheContinuousForceHoweverHot) {
  Heating heating(3, 9, 30, 1);
  for (int i = 0; i < 20; ++i) {
    heating.book(9, 0.1);
    ASSERT_GT(heating.heat(), 1);
    EXPECT_DOUBLE_EQ(heating.allowed(), 3) << heating.heat();
  }
}

TEST(Heating, BooksNoMoreThanThePeakNorTimeThatIsNone) {
  const auto after = [](double force, double dt) {
    Heating heating(3, 9, 30, 0.5);
    heating.book(force, dt);
    return heating.heat();
  };
  const double peak = 0.5 + 1e-3 / 30 * (9 - 0.5);
  for (const double force : {9.0, -9.0, 10.0, -1e300, double{NAN}, double{INFINITY}})
    EXPECT_NEAR(after(force, 1e-3), peak, 1e-12) << force;
  for (const double dt : {0.0, -1.0, double{NAN}}) EXPECT_EQ(after(9, dt), 0.5) << dt;
  for (const double dt : {30.0, 31.0, 1e9}) EXPECT_NEAR(after(1.5, dt), 0.25, 1e-12) << "at rest by then";
}

TEST(Heating, IsWarmUntilItHasCooledWellBelow) {
  Heating heating(3, 9, 30, 0.69);
  EXPECT_FALSE(heating.warm());
  heating.book(9, 0.1);
  ASSERT_GT(heating.heat(), Heating::kAnnounce);
  EXPECT_TRUE(heating.warm());
  while (heating.heat() > 0.601) {
    EXPECT_TRUE(heating.warm()) << heating.heat();
    heating.book(0, 0.02);
  }
  while (heating.heat() > 0.6) heating.book(0, 1e-3);
  EXPECT_FALSE(heating.warm());
  while (heating.heat() < 0.69) {
    EXPECT_FALSE(heating.warm()) << heating.heat();
    heating.book(9, 1e-3);
  }
}

/** Whatever is asked for: what is let through never heats beyond 1, is never below the continuous force, never jumps.
 */
TEST(HeatingProperty, NeverBeyondWhatTheMotorsStand) {
  for (const unsigned seed : seeds(40)) {
    Random random(seed);
    const double continuous = std::exp(random.in(-2, 3));
    const double peak = continuous * std::exp(random.in(0.01, 2.3));
    const double tau = std::exp(random.in(0, 5));
    Heating heating(continuous, peak, tau);
    double wanted = 0;
    double before = peak;
    bool announced = false;
    for (int i = 0; i < 20'000; ++i) {
      if (random.once(500)) {
        const double draws[] = {0, continuous, peak, 100 * peak, INFINITY, NAN, std::ldexp(peak, -30)};
        wanted = draws[random.below(std::size(draws))];
      }
      const double allowed = std::min(heating.allowed(), peak);
      ASSERT_GE(allowed, continuous * (1 - 1e-12));
      ASSERT_LE(std::abs(allowed - before),
                (peak - continuous) * kHeatDt / tau / 0.15 * peak * peak / (continuous * continuous) * 1.01);
      announced = announced || heating.warm();
      if (allowed < peak) {
        ASSERT_TRUE(announced) << "cut without a word";
      }
      heating.book(std::isfinite(wanted) ? std::min(wanted, allowed) : allowed, kHeatDt);
      ASSERT_LE(heating.heat(), 1 + 1e-12);
      before = allowed;
    }
  }
}

/** A guard of motors that stand 12 N for a while and 3 N for ever, and what it is asked. */
struct GuardOfWarmMotors {
  static GuardConfig config() {
    GuardConfig config;
    config.limits = {12, 1, 5000, 250, 5, 3, 1000, 1000};
    config.ramp_ns = 100'000'000;
    config.continuous_force = 3;
    config.peak_force = 12;
    config.heating_s = 2;
    return config;
  }
  GuardOfWarmMotors() {
    sample.fresh = true;
    input.dt = kHeatDt;
    input.sample = &sample;
  }
  Guard guard{config()};
  DeviceSample sample;
  GuardInput input;
  GuardOutput output;
};

/** The whole guard: clients ask for what they like, limits are raised to the peak, and the motors stand it. */
TEST(GuardHeating, WhateverIsAskedForTheMotorsStandIt) {
  GuardOfWarmMotors motors;
  auto& [guard, sample, input, output] = motors;
  Random random(seedOf(5));
  Heating oracle(3, 12, 2);
  bool warned = false;
  bool derated = false;
  Vec3 wanted = Vec3::Zero();
  for (int i = 0; i < 20'000; ++i) {
    input.now_ns = std::int64_t{i} * 1'000'000;
    if (i == 10) {
      ASSERT_EQ(guard.arm(), ErrorCode::kOk);
    }
    if (i > 200 && random.once(300)) wanted = random.vector(20);
    input.source[HD_SOURCE_CLIENT].force = wanted;
    guard.step(input, output);
    oracle.book(output.command.force.norm(), kHeatDt);
    ASSERT_LE(oracle.heat(), 1 + 1e-12);
    ASSERT_DOUBLE_EQ(output.heat, oracle.heat());
    warned = warned || output.warm;
    if (output.command.force.norm() < std::min(wanted.norm(), 12.0) * 0.99 && output.heat > Heating::kDerate) {
      derated = true;
      ASSERT_TRUE(warned);
    }
  }
  EXPECT_TRUE(derated) << "the test never came to the point";
}

/** A force that stands through periods that the servo missed heats as long. */
TEST(GuardHeating, PeriodsThatAreMissedCount) {
  GuardOfWarmMotors motors;
  auto& [guard, sample, input, output] = motors;
  Heating oracle(3, 12, 2);
  for (int i = 0; i < 5'000; ++i) {
    input.missed = i % 4;
    oracle.book(output.command.force.norm(), input.missed * kHeatDt);
    input.now_ns += (1 + std::int64_t{input.missed}) * 1'000'000;
    if (i == 10) {
      ASSERT_EQ(guard.arm(), ErrorCode::kOk);
    }
    if (i > 200) input.source[HD_SOURCE_CLIENT].force = Vec3(0, 0, 12);
    guard.step(input, output);
    oracle.book(output.command.force.norm(), kHeatDt);
    ASSERT_DOUBLE_EQ(output.heat, oracle.heat());
    ASSERT_LE(oracle.heat(), 1 + 1e-3);  // A tick may allow for more than its missed periods leave.
  }
  EXPECT_NEAR(output.heat, 1, 1e-2);
}

/** A slew limit, however slow, is for what is asked for; what the motors do not stand it does not hold. */
TEST(GuardHeating, NorDoesASlowSlewKeepThemHot) {
  for (const double slew : {10.0, 1.0, 0.0}) {
    GuardOfWarmMotors motors;
    auto& [guard, sample, input, output] = motors;
    for (int i = 0; i < 10'000; ++i) {
      input.now_ns = std::int64_t{i} * 1'000'000;
      if (i == 10) {
        ASSERT_EQ(guard.arm(), ErrorCode::kOk);
      }
      if (i == 150) input.source[HD_SOURCE_CLIENT].force = Vec3(0, 0, 12);
      if (i == 180) {
        ASSERT_GT(output.command.force.norm(), 11.9);
        auto limits = GuardOfWarmMotors::config().limits;
        limits.force_slew = slew;
        ASSERT_EQ(guard.setLimits(limits), ErrorCode::kOk);
      }
      guard.step(input, output);
      ASSERT_LE(output.heat, 1 + 1e-12) << "slew " << slew << " N/s";
    }
    EXPECT_NEAR(output.command.force.norm(), 3, 1e-3);
  }
}

}  // namespace
}  // namespace hapticd::test
