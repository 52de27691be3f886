// The simulated dynamics against closed forms.
#include "drivers/sim/linear_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/seeds.h"

namespace hapticd {
namespace {

constexpr double kStepTime_s = 62.5e-6;

struct State {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
};

State after(State s, double m, double c, double k, const Vec3& u, double coulomb, int steps, double h = kStepTime_s) {
  const LinearStep step = LinearStep::make(m, c, k, h);
  for (int i = 0; i < steps; ++i) step.advance(s.x, s.v, u, k, coulomb);
  return s;
}

TEST(LinearStep, DampedOscillationIsTheClosedForm) {
  const double m = 0.3, c = 1.2, k = 500, x0 = 0.02, v0 = -0.4;
  const double decay = c / (2 * m), rate = std::sqrt(k / m - decay * decay);
  for (const int steps : {1, 100, 16000}) {
    const double t = steps * kStepTime_s;
    const State s = after({Vec3(x0, 0, 0), Vec3(v0, 0, 0)}, m, c, k, Vec3::Zero(), 0, steps);
    const double a = x0, b = (v0 + decay * x0) / rate;
    const double x = std::exp(-decay * t) * (a * std::cos(rate * t) + b * std::sin(rate * t));
    EXPECT_NEAR(s.x.x(), x, 1e-13) << steps;
    EXPECT_EQ(s.x.y(), 0);
  }
}

TEST(LinearStep, UndampedOscillationKeepsItsEnergyForAMinute) {
  const double m = 0.2, k = 2000;
  const State s = after({Vec3(0.01, 0, 0), Vec3(0, 0.3, 0)}, m, 0, k, Vec3::Zero(), 0, 16000 * 60);
  const double energy = 0.5 * m * s.v.squaredNorm() + 0.5 * k * s.x.squaredNorm();
  const double start = 0.5 * m * 0.09 + 0.5 * k * 1e-4;
  EXPECT_NEAR(energy / start, 1, 1e-9);
}

TEST(LinearStep, OverdampedAndCriticalAreTheClosedForms) {
  const double m = 0.2, k = 100, x0 = 0.05;
  {
    const double c = 40, d = std::sqrt(c * c - 4 * m * k);
    const double r1 = (-c + d) / (2 * m), r2 = (-c - d) / (2 * m), t = 3200 * kStepTime_s;
    const State s = after({Vec3(0, x0, 0), Vec3::Zero()}, m, c, k, Vec3::Zero(), 0, 3200);
    EXPECT_NEAR(s.x.y(), x0 * (r2 * std::exp(r1 * t) - r1 * std::exp(r2 * t)) / (r2 - r1), 1e-13);
  }
  {
    const double r = std::sqrt(k / m), c = 2 * m * r, t = 3200 * kStepTime_s;
    const State s = after({Vec3(0, x0, 0), Vec3::Zero()}, m, c, k, Vec3::Zero(), 0, 3200);
    EXPECT_NEAR(s.x.y(), x0 * (1 + r * t) * std::exp(-r * t), 1e-12);
  }
}

TEST(LinearStep, ViscousDecayIsTheClosedForm) {
  const double m = 0.15, c = 2.5, v0 = 0.7, t = 8000 * kStepTime_s;
  const State s = after({Vec3::Zero(), Vec3(0, 0, v0)}, m, c, 0, Vec3::Zero(), 0, 8000);
  EXPECT_NEAR(s.v.z(), v0 * std::exp(-c / m * t), 1e-13);
  EXPECT_NEAR(s.x.z(), v0 * m / c * (1 - std::exp(-c / m * t)), 1e-13);
}

TEST(LinearStep, VeryStiffAndLongStepsStayExactAndStable) {
  // omega h = 20: far beyond where an explicit or symplectic step explodes.
  const double m = 0.05, k = 2e6, h = 3.1e-3, x0 = 0.01;
  const double rate = std::sqrt(k / m);
  const State s = after({Vec3(x0, 0, 0), Vec3::Zero()}, m, 0, k, Vec3::Zero(), 0, 100, h);
  EXPECT_NEAR(s.x.x(), x0 * std::cos(rate * 100 * h), 1e-10);
}

TEST(DryFriction, StopDistanceAndTimeAreTheClosedForms) {
  const double m = 0.2, f = 0.5, v0 = 0.4;
  const double distance = m * v0 * v0 / (2 * f), time = m * v0 / f;
  const LinearStep step = LinearStep::make(m, 0, 0, kStepTime_s);
  State s{Vec3::Zero(), Vec3(v0, 0, 0)};
  int steps = 0;
  while (s.v.x() != 0 && steps < 100000) {
    step.advance(s.x, s.v, Vec3::Zero(), 0, f);
    EXPECT_GE(s.v.x(), 0) << "friction never reverses the motion";
    ++steps;
  }
  EXPECT_NEAR(steps * kStepTime_s, time, kStepTime_s);
  EXPECT_NEAR(s.x.x(), distance, 0.5 * f / m * kStepTime_s * kStepTime_s);
  const Vec3 rest = s.x;
  for (int i = 0; i < 1000; ++i) step.advance(s.x, s.v, Vec3::Zero(), 0, f);
  EXPECT_EQ(s.x, rest) << "no chatter, no creep";
}

TEST(DryFriction, HoldsBelowAndSlidesAbove) {
  const double m = 0.2, f = 0.5;
  State s = after({}, m, 0.3, 0, Vec3(0.3, 0.3999, 0), f, 16000);
  EXPECT_EQ(s.x, Vec3::Zero());
  EXPECT_EQ(s.v, Vec3::Zero());
  s = after({}, m, 0, 0, Vec3(0.6, 0.8, 0), f, 1600);
  const double t = 0.1;
  EXPECT_NEAR(s.v.norm(), (1.0 - f) / m * t, 1e-12);
  EXPECT_NEAR(s.v.x() / s.v.norm(), 0.6, 1e-12) << "friction opposes the motion, not an axis";
}

TEST(DryFriction, WhatSticksDoesNotCreep) {
  std::mt19937 random(seedOf(3));
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) { return Vec3(size * unit(random), size * unit(random), size * unit(random)); };
  for (int i = 0; i < 300; ++i) {
    const double k = 1000 * (1 + unit(random)), m = 0.2 + 0.1 * unit(random);
    const Vec3 x0 = vector(1e-4), u = vector(0.15);  // At most 0.35 + 0.26 N against 0.7 N.
    const State s = after({x0, Vec3::Zero()}, m, 2 * (1 + unit(random)), k, u, 0.7, 2000);
    EXPECT_EQ(s.x, x0) << "not by a bit: " << (s.x - x0).norm();
  }
}

TEST(DryFriction, SpringLosesFourFrictionsOverStiffnessPerCycle) {
  // Each half cycle is a half cosine about +-f/k: the amplitude falls by 2 f / k, exactly.
  const double m = 0.1, k = 1000, f = 0.5, x0 = 0.0103;
  const LinearStep step = LinearStep::make(m, 0, k, kStepTime_s);
  State s{Vec3(x0, 0, 0), Vec3::Zero()};
  double expected = x0, previous = 0;
  int turns = 0;
  for (int i = 0; i < 32000; ++i) {
    previous = s.v.x();
    step.advance(s.x, s.v, Vec3::Zero(), k, f);
    const bool turned = previous != 0 && (s.v.x() == 0 || (s.v.x() > 0) != (previous > 0));
    if (turned) {
      expected -= 2 * f / k;
      ++turns;
      EXPECT_NEAR(std::abs(s.x.x()), expected, 3e-7) << turns;
    }
  }
  EXPECT_EQ(turns, 10);
  EXPECT_EQ(s.v.x(), 0);
  EXPECT_LE(std::abs(s.x.x()), f / k);
}

TEST(DryFriction, NeverAddsEnergy) {
  const double m = 0.1, k = 800;
  const LinearStep step = LinearStep::make(m, 0.2, k, kStepTime_s);
  State s{Vec3(0.01, -0.004, 0.002), Vec3(-0.1, 0.5, 0.3)};
  double energy = 1e9;
  for (int i = 0; i < 20000; ++i) {
    step.advance(s.x, s.v, Vec3::Zero(), k, 0.2);
    const double now = 0.5 * m * s.v.squaredNorm() + 0.5 * k * s.x.squaredNorm();
    ASSERT_LE(now, energy + 1e-15) << i;
    energy = now;
  }
}

}  // namespace
}  // namespace hapticd
