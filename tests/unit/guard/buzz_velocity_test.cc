// The velocity that damps a buzz, against closed forms and bounds.
#include "rt/guard/buzz_velocity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/seeds.h"

namespace hapticd {
namespace {

constexpr double kStep = 1e-5;

Vec3 along(double x) { return {x, 0, 0}; }

TEST(BuzzVelocity, WithoutStepsItIsTheLastTicksExtrapolatedByItsChange) {
  BuzzVelocity v;
  v.update(along(1e-4), 1e-3, 0);
  v.update(along(3e-4), 1e-3, 0);
  EXPECT_NEAR(v.velocity().x(), 0.3 + 0.2, 1e-12);
  v.update(along(2e-4), 1e-3, 2);
  EXPECT_NEAR(v.velocity().x(), 0.2 - 3 * 0.1, 1e-12) << "a loop that is two ticks late";
  v.update(along(3e-4), 1e-3, 16);
  EXPECT_NEAR(v.velocity().x(), 0.3 + BuzzVelocity::kMostLead * 0.1, 1e-12) << "bounded";
  v.reset();
  EXPECT_EQ(v.velocity(), Vec3(0, 0, 0));
  v.update(along(0), 1e-3, 0);
  EXPECT_EQ(v.velocity(), Vec3(0, 0, 0));
}

TEST(BuzzVelocity, NearAStepTheWindowGrowsToAMillisecondAndNoFurther) {
  for (const auto& [rate_hz, ticks] : {std::pair{1000.0, 1}, {2000.0, 2}, {4000.0, 4}}) {
    BuzzVelocity v;
    v.setResolution(kStep);
    for (int i = 0; i < 16; ++i) v.update(along(0), 1 / rate_hz, 0);
    v.update(along(kStep), 1 / rate_hz, 0);
    EXPECT_NEAR(v.velocity().x(), kStep * rate_hz / ticks, 1e-12) << rate_hz;
    for (int i = 1; i < ticks; ++i) v.update(along(0), 1 / rate_hz, 0);
    EXPECT_GT(v.velocity().x(), 0) << rate_hz;
    v.update(along(0), 1 / rate_hz, 0);
    EXPECT_EQ(v.velocity().x(), 0) << rate_hz << ": a hand at rest";
  }
}

TEST(BuzzVelocity, WhatStepsExplainIsNoChange) {
  // At any speed the readings of a steady motion jump by a step either way; the extrapolation must not see it.
  for (const double speed : {0.003, 0.0317, 0.1234, 0.777}) {
    BuzzVelocity v;
    v.setResolution(kStep);
    const double dt = 1.0 / 4000;
    double read = 0;
    for (int i = 1; i < 2000; ++i) {
      const double now = kStep * std::round(speed * i * dt / kStep);
      v.update(along(now - read), dt, 3);
      read = now;
      // One window is wrong by a step at most, over the ticks that it has.
      if (i <= 8) continue;
      EXPECT_LE(std::abs(v.velocity().x() - speed), kStep / dt * (1 + 1e-9)) << speed << " " << i;
    }
  }
}

TEST(BuzzVelocity, IsAsYoungAsAVibrationNeeds) {
  // Against a sine of 60 Hz, sampled without steps, as it will be when the force acts: delay + 1 ticks after the middle
  // of the last. A straight line errs by its curvature: w^2 A n (n + 1) / 2 dt in the worst case; the plain
  // displacement by w A w n dt, which is ten times as much.
  constexpr double kRate = 4000, kAmplitude = 1e-4, kW = 2 * std::numbers::pi * 60;
  for (const double delay : {0.0, 1.0, 3.0}) {
    BuzzVelocity v;
    double worst = 0, plain = 0;
    const auto x = [&](double tick) { return kAmplitude * std::sin(kW * tick / kRate); };
    for (int i = 1; i < 500; ++i) {
      v.update(along(x(i) - x(i - 1)), 1 / kRate, delay);
      if (i < 3) continue;
      const double n = delay + 1, due = kAmplitude * kW * std::cos(kW * (i - 0.5 + n) / kRate);
      worst = std::max(worst, std::abs(v.velocity().x() - due));
      plain = std::max(plain, std::abs((x(i) - x(i - 1)) * kRate - due));
    }
    const double n = delay + 1, angle = kW / kRate;
    EXPECT_LE(worst, kAmplitude * kW * angle * angle * n * (n + 1) / 2 * 1.05) << delay;
    EXPECT_GT(plain, 3 * worst) << delay;
  }
}

TEST(BuzzVelocity, StaysWithinABoundWhateverIsRead) {
  // (1 + 2 kMostLead) times the largest displacement of a tick.
  BuzzVelocity v;
  v.setResolution(kStep);
  std::uint64_t state = seedOf(1);
  for (int i = 0; i < 5000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const double moved = (static_cast<double>(state >> 40) / (1 << 23) - 1) * 1e-3;
    v.update(along(moved), 1e-3, 16);
    ASSERT_LE(std::abs(v.velocity().x()), (1 + 2 * BuzzVelocity::kMostLead) * 1.0 + 1e-12);
  }
}

/** Of a fast loop the last four ticks and not one more; of a slow one the last. */
TEST(BuzzVelocity, TheWindowHasItsMost) {
  for (const double dt : {1e-4, 2.5e-4, 1e-3, 3e-3}) {
    BuzzVelocity v;
    v.setResolution(1);  // No step is sure.
    for (const double moved : {7e-6, 1e-6, 2e-6, 3e-6, 4e-6}) v.update({moved, 0, 0}, dt, 0);
    EXPECT_NEAR(v.velocity().x() * dt, dt < 1e-3 ? 2.5e-6 : 4e-6, 1e-15) << dt;
  }
}

/** Two steps of the change may be wrong; what is beyond leads by as much as the loop is late, four ticks at most. */
TEST(BuzzVelocity, LeadsByWhatIsSureOfTheLastChange) {
  const double step = 1e-5, moved = 2.8e-5, dt = 1e-3;
  for (const double delay : {0.0, 1.0, 2.5, 3.0, 10.0}) {
    BuzzVelocity v;
    v.setResolution(step);
    v.update({0, moved, 0}, dt, delay);
    EXPECT_NEAR(v.velocity().y(), (moved + std::min(4.0, delay + 1) * (moved - 2 * step)) / dt, 1e-12) << delay;
  }
  for (const double none : {0.0, -1e-3, double{NAN}, double{INFINITY}}) {
    BuzzVelocity v;
    v.setResolution(none);
    v.update({0, moved, 0}, dt, 0);
    EXPECT_NEAR(v.velocity().y(), 2 * moved / dt, 1e-12) << none;
  }
}

}  // namespace
}  // namespace hapticd
