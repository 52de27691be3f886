/** @file
 * Medians, their intervals and percentiles.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/collide/timing.h"
#include "tools/haptic-bench/metric/quantile.h"
#include "tools/haptic-bench/readable.h"

namespace haptic_bench {
namespace {

/** 1 to n. */
std::vector<double> counted(std::size_t n) {
  std::vector<double> all(n);
  std::iota(all.begin(), all.end(), 1.0);
  return all;
}

TEST(Estimates, IntervalsAreThoseOfTheBinomialTable) {
  // Conover, table A3: the k-th smallest and k-th largest of n with 2 P(Binomial(n, 1/2) < k) <= 0.05.
  const struct {
    std::size_t n, k;
  } known[] = {{5, 1}, {6, 1}, {8, 1}, {9, 2}, {12, 3}, {15, 4}, {20, 6}, {25, 8}, {100, 40}};
  for (const auto& [n, k] : known) {
    const Estimate e = estimate(counted(n));
    EXPECT_EQ(e.low, static_cast<double>(k)) << n;
    EXPECT_EQ(e.high, static_cast<double>(n + 1 - k)) << n;
    EXPECT_EQ(e.median, static_cast<double>(n + 1) / 2) << n;
  }
}

TEST(Estimates, IntervalsOfManyRoundsAreThoseOfTheNormalDistribution) {
  for (const std::size_t n : {1000u, 2000u, 10000u}) {
    const Estimate e = estimate(counted(n));
    const double half = 0.98 * std::sqrt(static_cast<double>(n));  // 1.96 sqrt(n) / 2
    EXPECT_NEAR(e.low, static_cast<double>(n) / 2 - half, 2) << n;
    EXPECT_NEAR(e.high, static_cast<double>(n) / 2 + half, 2) << n;
  }
}

TEST(Units, AreThoseThatReadEasily) {
  const struct {
    const char* unit;
    double value;
    const char* shown;
    double factor;
  } cases[] = {{"ns", 9999, "ns", 1},  {"ns", -10000, "us", 1e-3}, {"ns", 3e8, "ms", 1e-6},
               {"s", 0.05, "ms", 1e3}, {"m", 2.7e-4, "mm", 1e3},   {"m", 1e-30, "um", 1e6},
               {"J", 0, "J", 1},       {"J", 0.1, "J", 1},         {"byte", 1.176e6, "kB", 1e-3},
               {"s", 1e9, "s", 1},     {"N^2", 1e9, "N^2", 1},     {"ns", INFINITY, "ns", 1}};
  for (const auto& c : cases) {
    const Readable read = readable(c.unit, c.value);
    EXPECT_EQ(read.unit, c.shown) << c.value;
    EXPECT_NEAR(read.factor, c.factor, 1e-12 * c.factor) << c.value;
  }
}

TEST(Percentiles, AreByNearestRankEverywhere) {
  EXPECT_EQ(nearestRank(counted(1), 0.99), 1);
  EXPECT_EQ(nearestRank(counted(100), 0.99), 99) << "not the greatest";
  EXPECT_EQ(nearestRank(counted(1000), 0.999), 999);
  EXPECT_EQ(nearestRank(counted(1001), 0.999), 1000);
  EXPECT_EQ(nearestRank(counted(4), 0.5), 2);
  EXPECT_EQ(nearestRank(counted(7), 1), 7);
  const Times times = summarise(counted(1000));
  EXPECT_EQ(times.p50, 500);
  EXPECT_EQ(times.p99, 990);
  EXPECT_EQ(times.p999, 999);
  EXPECT_EQ(times.steady999, 999);
}

TEST(Percentiles, TheMiddleOneOfAnEvenNumberLiesBetweenTwo) {
  const auto middle = [](std::vector<std::int64_t> samples) { return middleOf(samples); };
  EXPECT_EQ(middle({7}), 7);
  EXPECT_EQ(middle({9, 2}), 5.5);
  EXPECT_EQ(middle({5, 100, -3}), 5);
  EXPECT_EQ(middle({8, 1, 90, 3}), 5.5) << "of what is below the upper one the greatest, wherever it stands";
  EXPECT_EQ(middle({6, 5, 4, 3, 2, 1}), 3.5);
}

}  // namespace
}  // namespace haptic_bench
