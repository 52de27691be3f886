// Pooled quantiles by brute force, and an interval that holds a known ratio as often as it says.
#include "tools/haptic-bench/load/wakes.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/seeds.h"

namespace haptic_bench {
namespace {

TEST(Wakes, PooledQuantileIsTheRankOfAllTogether) {
  const std::vector<Wakes> slices{{5, 1, 9}, {}, {2, 7, 3, 8}, {4, 6, 10}};
  for (int n = 1; n <= 10; ++n) EXPECT_EQ(pooledQuantile(slices, n / 10.0), n);
  EXPECT_EQ(pooledQuantile(slices, 0.05), 1);
  EXPECT_EQ(pooledQuantile({}, 0.5), 0);
}

TEST(Wakes, TheIntervalHoldsTheTrueRatio) {
  // Slices whose level differs, as under bursts of load, but is shared by the two of a pair. b is twice a.
  std::mt19937 random(hapticd::seedOf(7));
  std::lognormal_distribution<double> level(8, 0.3), one(0, 0.5);
  int held = 0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Wakes> a(30), b(30);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double burst = level(random);
      for (int n = 0; n < 100; ++n) {
        a[i].push_back(static_cast<std::int64_t>(burst * one(random)));
        b[i].push_back(static_cast<std::int64_t>(2 * burst * one(random)));
      }
    }
    const Interval ratio = pooledRatio(a, b, 0.99, 3);
    EXPECT_LE(ratio.low, ratio.value);
    EXPECT_GE(ratio.high, ratio.value);
    held += ratio.low <= 0.5 && 0.5 <= ratio.high ? 1 : 0;
  }
  EXPECT_GE(held, kTrials * 85 / 100);  // 95 % of them; chance and the bootstrap's bias take a few
}

}  // namespace
}  // namespace haptic_bench
