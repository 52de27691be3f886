// The closed loop: theory against closed forms and brute force, the search against theory.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/zwidth/buzz.h"
#include "tools/haptic-bench/zwidth/eigenvalue.h"
#include "tools/haptic-bench/zwidth/search.h"
#include "tools/haptic-bench/zwidth/sweep.h"
#include "tools/haptic-bench/zwidth/theory.h"

namespace haptic_bench::zwidth {
namespace {

Loop idealLoop(double rate_hz, std::uint32_t delay) {
  return makeLoop("sim://default", {rate_hz, delay, kIdealStep, 0});
}

TEST(ZwidthTheory, ColgatesGeneralConditionIsTheSimpleOneWithoutDelay) {
  for (const double damping : {0.0, 0.3, 1.5}) {
    EXPECT_NEAR(colgateDelayed(2, damping, 1e-3, 0), colgate(2, damping, 1e-3), 1e-6);
    EXPECT_NEAR(colgate(2, damping, 1e-3), 2 * (2 - damping) / 1e-3, 1e-9);
  }
  EXPECT_EQ(colgate(1, 2, 1e-3), 0);
  // At low frequency delay d adds d T to the T / 2 of the hold: b > K T (1/2 + d). That is the narrowest place.
  for (const std::uint32_t delay : {1u, 2u, 3u}) {
    EXPECT_NEAR(colgateDelayed(2, 0, 1e-3, delay) * 1e-3 * (0.5 + delay) / 2, 1, 1e-4);
  }
  EXPECT_DOUBLE_EQ(frictionLimit(0.1, 1e-5), 20000);
}

TEST(ZwidthTheory, ATickOfDelayTurnsTheWallsDampingAgainstIt) {
  // b + B cos 2x > K T/2 (1 + 2 cos x). By c = cos x: the narrowest place is 2 c = sqrt(2 b / B - 1) - 1, or c = 1.
  for (const double damping : {0.0, 0.2, 0.39, 0.41, 1.0, 1.9}) {
    const double within = 2 * damping * (std::sqrt(2 * 2 / damping - 1) - 1) / 1e-3;
    const double at_rest = 2 * (2 + damping) / (3 * 1e-3);
    EXPECT_NEAR(colgateDelayed(2, damping, 1e-3, 1), 5 * damping > 2 ? within : at_rest, 1e-2) << damping;
  }
  for (const std::uint32_t delay : {0u, 1u, 2u, 5u}) EXPECT_EQ(colgateDelayed(2, 2.01, 1e-3, delay), 0) << delay;
}

/** Whether the linear loop, simulated tick by tick with two thousand steps of Euler's in each, dies away. */
bool decays(const Loop& loop, double stiffness, double damping, std::uint32_t window) {
  const hapticd::SimParameters& p = loop.device.parameters;
  const double tick = 1 / loop.rate_hz;
  const int steps = 2000;
  std::vector<double> x(window + 1, 1e-3), f(loop.delay + 1, 0.0);
  double place = 1e-3, v = 0, early = 0, late = 0;
  const int ticks = 1500;
  for (int n = 0; n < ticks; ++n) {
    x.insert(x.begin(), place);
    x.pop_back();
    f.insert(f.begin(), -stiffness * x[0] - damping * (x[0] - x[window]) / (window * tick));
    f.pop_back();
    for (int i = 0; i < steps; ++i) {
      const double h = tick / steps;
      v += h / (p.mass + p.hand_mass) * (f[loop.delay] - (p.viscous + p.hand_damping) * v - p.hand_stiffness * place);
      place += h * v;
    }
    if (n >= 100 && n < 300) early = std::max(early, std::abs(place));
    if (n >= ticks - 200) late = std::max(late, std::abs(place));
  }
  return late < early;
}

TEST(ZwidthTheory, EigenvalueLimitIsWhereABruteSimulationTurns) {
  for (const std::uint32_t delay : {0u, 2u}) {
    for (const std::uint32_t window : {1u, 4u}) {
      const Loop loop = idealLoop(1000, delay);
      const double limit = eigenvalueLimit(loop, 10, window);
      ASSERT_GT(limit, 100);
      EXPECT_TRUE(decays(loop, 0.98 * limit, 10, window)) << delay << " " << window;
      EXPECT_FALSE(decays(loop, 1.02 * limit, 10, window)) << delay << " " << window;
    }
  }
  // Gil et al. 2009: K = (b + B) / (T / 2 + delay), to first order.
  EXPECT_NEAR(eigenvalueLimit(idealLoop(4000, 1), 0) / (6.5 / 0.375e-3), 1, 0.01);
  EXPECT_LE(slowestLimit(idealLoop(1000, 1), 40), eigenvalueLimit(idealLoop(1000, 1), 40, 15));
}

TEST(ZwidthTheory, EigenvalueLimitKeepsItsDigits) {
  // By numpy, from the characteristic polynomial and from the matrix, which agree to nine digits.
  const auto limit = [](const char* uri, double rate_hz, std::uint32_t delay, double damping) {
    return eigenvalueLimit(makeLoop(uri, {rate_hz, delay, kIdealStep, 0}), damping);
  };
  const char* light = "sim://default?mass=1&viscous=0.2&hand_mass=0.1&hand_stiffness=300&hand_damping=1";
  const char* heavy = "sim://default?mass=4&viscous=2&hand_mass=1&hand_stiffness=500&hand_damping=15";
  EXPECT_NEAR(limit(light, 3000, 4, 120) / 74613.7496, 1, 2e-6);
  EXPECT_NEAR(limit(heavy, 3000, 4, 30) / 31231.0323, 1, 2e-6);
}

TEST(ZwidthBuzz, ASineAboveCountsWithHalfItsSquareAndOneBelowDoesNot) {
  std::vector<double> signal;
  for (int i = 0; i < 1000; ++i) {
    const double t = i * 1e-3;
    signal.push_back(7 + 3 * std::sin(2 * std::numbers::pi * 4 * t) + 0.2 * std::sin(2 * std::numbers::pi * 110.3 * t));
  }
  EXPECT_NEAR(powerAbove(signal, 1000, 30), 0.02, 2e-4);
  EXPECT_NEAR(powerAbove(signal, 1000, 200), 0, 1e-6);
  EXPECT_NEAR(powerAbove(signal, 1000, 1), 4.52, 0.02);
}

TEST(ZwidthBuzz, TheFastestThatThereIsCountsWhole) {
  for (const std::size_t n : {8u, 1000u, 1001u}) {
    std::vector<double> signal;
    for (std::size_t i = 0; i < n; ++i) signal.push_back(i % 2 == 0 ? 0.3 : -0.3);
    EXPECT_NEAR(powerAbove(signal, 1000, 30), 0.09, 1e-4) << n << ": of a sign that alternates the square is its own";
  }
  EXPECT_EQ(powerAbove(std::vector<double>{1, -1, 1, -1, 1, -1, 1}, 1000, 30), 0) << "too few";
}

TEST(ZwidthSearch, FindsTheEigenvalueLimitAndTheControllerDoublesIt) {
  for (const std::uint32_t delay : {0u, 2u}) {
    Loop loop = idealLoop(1000, delay);
    const double limit = eigenvalueLimit(loop, 2);
    const double off = largestStable(loop, 2, limit).stiffness;
    EXPECT_NEAR(off / limit, 1, 0.05) << delay;
    loop.passivity = true;
    const Limit on = largestStable(loop, 2, off);
    EXPECT_GT(on.stiffness / off, 2) << delay;
    EXPECT_NEAR(on.at.displayed / on.stiffness, 1, 0.05) << delay;
  }
}

TEST(ZwidthSearch, AHeavyHandIsGivenItsTime) {
  const char* heavy = "sim://default?mass=1.5&viscous=3&hand_mass=0.5&hand_stiffness=800&hand_damping=10";
  const Loop loop = makeLoop(heavy, {3000, 0, kIdealStep, 0});
  EXPECT_NEAR(trialLength(loop), 50 * 2 / 13.0, 1e-9);
  EXPECT_EQ(trialLength(idealLoop(1000, 0)), kTrial_s);
  const double limit = eigenvalueLimit(loop, 0);
  EXPECT_NEAR(largestStable(loop, 0, limit).stiffness / limit, 1, 0.03) << "its bounces last three seconds";
  const Loop light =
      makeLoop("sim://default?mass=1&viscous=0.2&hand_mass=0.1&hand_damping=1", {1000, 0, kIdealStep, 0});
  EXPECT_EQ(trialLength(light), 30);
  const double its = eigenvalueLimit(light, 0);
  EXPECT_NEAR(largestStable(light, 0, its).stiffness / its, 1, 0.03)
      << "it loses a tenth in seconds, well below the limit";
}

TEST(ZwidthSearch, TheSoftestIsTriedToo) {
  const Loop loop = makeLoop("sim://default?hand_damping=0.1&viscous=0.02", {1000, 8, kIdealStep, 0});
  const double limit = eigenvalueLimit(loop, 0);
  EXPECT_LT(limit, 20) << "the search begins at half of it, below 10 N/m";
  EXPECT_NEAR(largestStable(loop, 0, limit).stiffness / limit, 1, 0.05);
}

TEST(ZwidthSearch, ABadGuessLeadsToTheSameWall) {
  const Loop loop = idealLoop(1000, 1);
  const double limit = eigenvalueLimit(loop, 2);
  for (const double guess : {0.03, 0.4, 1.0, 5.0, 80.0})
    EXPECT_NEAR(largestStable(loop, 2, guess * limit).stiffness / limit, 1, 0.05) << guess;
}

TEST(ZwidthSearch, DryFrictionHelps) {
  const double without = largestStable(makeLoop("sim://default", {1000, 0, 1e-5, 0}), 0, 13000).stiffness;
  const double with = largestStable(makeLoop("sim://default", {1000, 0, 1e-5, 0.1}), 0, 13000).stiffness;
  EXPECT_GT(with, 1.1 * without);
}

TEST(ZwidthSearch, WhatMotorsBearForEverDoesNotBindAPressOfSeconds) {
  const Loop loop = makeLoop("sim://touchx", {1000, 0, kIdealStep, 0});
  ASSERT_LT(loop.device.info.continuous_force, loop.push);
  const double limit = eigenvalueLimit(loop, 2);
  const Limit found = largestStable(loop, 2, limit);
  EXPECT_NEAR(found.stiffness / limit, 1, 0.05);
  EXPECT_NEAR(found.at.displayed / found.stiffness, 1, 0.05);
}

TEST(ZwidthSearch, ARowIsMeasuredWithoutTheControllerAndWithIt) {
  Options options{.rates_hz = {1000}, .delays = {1}, .dampings = {2}, .push = 3, .force_slew = 1e5};
  Row row = plan(options).back();  // As the device is.
  measure(options, row);
  Loop loop = makeLoop(options.uri, row.change);
  loop.push = 3;
  loop.force_slew = 1e5;
  const auto stable = [&](double stiffness) { return tap(loop, {stiffness, 2}).stable; };
  EXPECT_GE(row.off, 0.95 * row.slowest);
  EXPECT_TRUE(stable(row.off));
  EXPECT_FALSE(stable(1.02 * row.off));
  EXPECT_EQ(row.buzz_off, tap(loop, {0.9 * row.off, 2}).buzz);
  loop.passivity = true;
  EXPECT_GT(row.on, 2 * row.off);
  EXPECT_TRUE(stable(row.on));
  EXPECT_FALSE(stable(1.02 * row.on));
  EXPECT_EQ(row.buzz_on, tap(loop, {0.9 * row.off, 2}).buzz) << "of the same wall";
  EXPECT_DOUBLE_EQ(row.displayed, tap(loop, {row.on, 2}).displayed / row.on);
}

TEST(ZwidthSearch, WhereNoWallIsStableNoneBuzzes) {
  Options options{.rates_hz = {500}, .delays = {0}, .dampings = {1000}, .quick = true};
  for (Row& row : plan(options)) {
    measure(options, row);
    ASSERT_EQ(row.off, 0);
    EXPECT_TRUE(std::isnan(row.buzz_off) && std::isnan(row.buzz_on)) << "that of the damper, in which the hand hangs";
  }
}

TEST(ZwidthSearch, RepeatsBitForBit) {
  const Loop loop = makeLoop("sim://touchx", {1000, 0, -1, -1});
  const Tap a = tap(loop, {700, 1}), b = tap(loop, {700, 1});
  EXPECT_EQ(a.buzz, b.buzz);
  EXPECT_EQ(a.late_m, b.late_m);
}

TEST(ZwidthGoals, JudgeNamesWhatIsMissed) {
  Row good;
  good.change.rate_hz = 1000;
  good.step = kIdealStep;
  good.eigenvalue = good.slowest = 1000;
  good.colgate_delayed = 500;
  good.off = 990;
  good.on = 2100;
  good.displayed = 1;
  Row stiff = good;
  stiff.damping = 10;
  stiff.eigenvalue = 3000;
  stiff.off = 2900;
  stiff.on = 3000;
  for (const Goal& goal : judge({good, stiff})) EXPECT_EQ(goal.missed, 0) << goal.name;
  const auto missed = [&](const Row& row) {
    int count = 0;
    for (const Goal& goal : judge({row, stiff})) count += goal.missed;
    return count;
  };
  Row bad = good;
  bad.off = 940;
  EXPECT_EQ(missed(bad), 1) << "not within 5 % of the limit";
  bad = good;
  bad.on = 1900;
  EXPECT_EQ(missed(bad), 1) << "not twice";
  bad = good;
  bad.displayed = 0.9;
  EXPECT_EQ(missed(bad), 1) << "softer than asked for";
  bad = good;
  bad.colgate_delayed = 1000;
  EXPECT_EQ(missed(bad), 1) << "below Colgate";
  bad = good;
  bad.off = 1060;
  bad.on = 2300;
  EXPECT_EQ(missed(bad), 1) << "beyond the limit, which cannot be";
  bad.friction = 0.1;
  EXPECT_EQ(missed(bad), 0) << "with dry friction it can";
  bad = good;
  bad.displayed = 1.1;
  EXPECT_EQ(missed(bad), 1) << "stiffer than asked for";
  bad = good;
  bad.on = bad.displayed = 0;
  EXPECT_EQ(missed(bad), 1) << "no wall at all: not twice, and nothing that is displayed";

  Row real = stiff;
  real.step = 1e-5;
  real.friction = 0.1;
  EXPECT_EQ(missed(real), 0);
  real.off = 5000;
  real.on = 5100;
  EXPECT_EQ(missed(real), 0) << "friction helps";
  real.off = 940;
  EXPECT_EQ(missed(real), 1) << "below the limit at the estimator's slowest";
  real.off = 2900;
  real.on = 2800;
  EXPECT_EQ(missed(real), 1) << "the best wall is lower with the controller";
  real.on = 2850;
  EXPECT_EQ(missed(real), 0) << "as well as the search finds them";

  // Twice is asked where off is at most half the best of its own curve, up to that.
  const auto twice = [](const std::vector<Row>& rows) { return judge(rows)[3]; };
  EXPECT_EQ(twice({good, stiff}).rows, 1);
  EXPECT_DOUBLE_EQ(twice({good, stiff}).worst, 2100.0 / 990);
  Row beyond = good;
  beyond.damping = 20;
  EXPECT_EQ(twice({good, stiff, beyond}).rows, 1);
  Row soft = good;
  soft.damping = 5;
  soft.on = 2500;
  EXPECT_EQ(twice({soft, good, stiff}).rows, 2);
  EXPECT_DOUBLE_EQ(twice({soft, good, stiff}).worst, 2100.0 / 990);
  for (const auto& change : {Change{500, 0, kIdealStep, 0}, Change{1000, 1, kIdealStep, 0}}) {
    Row other = good;
    other.change = change;
    EXPECT_EQ(twice({other, stiff}).rows, 0);
  }
}

TEST(ZwidthLoop, PlansEachRowOnceWithItsLimits) {
  const char* const uri = "sim://default?viscous=2&coulomb=0.1&resolution=1e-5";
  const std::vector<Row> rows =
      plan({.uri = uri, .rates_hz = {1000, 500, 1000}, .delays = {2, 0}, .dampings = {1.5, 0, 1.5}});
  ASSERT_EQ(rows.size(), 2u * 2 * 2 * 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const double rate = row.change.rate_hz;
    EXPECT_DOUBLE_EQ(row.colgate, 2 * (2 - row.damping) * rate);
    if (row.change.delay == 0) {
      EXPECT_NEAR(row.colgate_delayed, row.colgate, 1e-6);
    } else {
      EXPECT_LT(row.colgate_delayed, 0.9 * row.colgate);
    }
    EXPECT_DOUBLE_EQ(row.friction_limit, row.friction > 0 ? 2 * 0.1 / 1e-5 : 0);
    EXPECT_TRUE(row.friction == 0 || (row.friction == 0.1 && row.step == 1e-5));
    EXPECT_TRUE(row.step == 1e-5 || row.step == kIdealStep);
    EXPECT_EQ(row.eigenvalue, eigenvalueLimit(makeLoop(uri, {rate, row.change.delay, kIdealStep, 0}), row.damping));
    EXPECT_GT(row.slowest, 0);
    if (row.damping == 0) {
      EXPECT_EQ(row.slowest, row.eigenvalue);
    }
    if (i == 0) continue;
    const auto key = [](const Row& r) { return std::tuple(r.change.rate_hz, r.change.delay, r.friction, r.step); };
    EXPECT_LE(key(rows[i - 1]), key(row)) << "sorted";
    EXPECT_TRUE(key(rows[i - 1]) < key(row) || rows[i - 1].damping != row.damping);
  }
}

TEST(ZwidthLoop, SweepsADeviceOnceThatIsTwoOfTheThree) {
  // compare() takes a table's row once alone.
  const auto rows = [](const char* uri) {
    return plan({.uri = uri, .rates_hz = {1000}, .delays = {0}, .dampings = {0}}).size();
  };
  EXPECT_EQ(rows("sim://default"), 3u);
  EXPECT_EQ(rows("sim://default?coulomb=0"), 2u);
  EXPECT_EQ(rows("sim://default?resolution=1e-9"), 2u);
  EXPECT_EQ(rows("sim://default?resolution=1e-9&coulomb=0"), 1u);
}

TEST(ZwidthLoop, RefusesWhatCannotBeSwept) {
  EXPECT_THROW((void)makeLoop("replay://somewhere.csv", {}), Failure);
  EXPECT_THROW((void)makeLoop("sim://default?hand_stiffness=0", {}), Failure);
  EXPECT_THROW((void)makeLoop("sim://defualt", {}), Failure);
  EXPECT_THROW((void)makeLoop("sim://default?lower=-0.1,-0.1,-0.1&upper=0.1,0.1,-0.02", {}), Failure)
      << "its stop lies within the wall";
  EXPECT_THROW((void)makeLoop("sim://default?lower=-0.1,-0.1,0&upper=0.1,0.1,0.1", {}), Failure)
      << "its stop holds the hand, not the wall";
  EXPECT_EQ(makeLoop("sim://touch?motion=tap", {}).device.parameters.motion, "live");
  Options weak{.uri = "sim://touch", .rates_hz = {1000}, .delays = {0}, .dampings = {0}, .push = 4};
  EXPECT_THROW((void)plan(weak), Failure) << "4 N are more than its 3.3 N: no wall holds such a hand";
  weak.push = 3;
  EXPECT_EQ(plan(weak).size(), 3u);
}

TEST(ZwidthLoop, PressesWeakDevicesLess) {
  EXPECT_DOUBLE_EQ(usualPush("sim://default"), 4);
  EXPECT_DOUBLE_EQ(usualPush("sim://touch"), 0.6 * 3.3);
  EXPECT_EQ(plan({.uri = "sim://touch", .rates_hz = {1000}, .delays = {0}, .dampings = {0}}).size(), 3u);
}

}  // namespace
}  // namespace haptic_bench::zwidth
