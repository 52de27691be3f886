#include "rt/base/histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/seeds.h"

namespace hapticd {
namespace {

TEST(Histogram, EmptyIsAllZero) {
  const Histogram h;
  const auto s = h.summary();
  EXPECT_EQ(s.count, 0u);
  EXPECT_EQ(s.p50_ns, 0u);
  EXPECT_EQ(s.max_ns, 0u);
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram h;
  for (int i = 1; i <= 31; ++i) h.record(i);
  h.record(-5);
  const auto s = h.summary();
  EXPECT_EQ(s.count, 32u);
  EXPECT_EQ(s.p50_ns, 15u);
  EXPECT_EQ(s.max_ns, 31u);
  EXPECT_EQ(s.p9999_ns, 31u);
}

// Oracle: the sorted samples. A percentile is its bucket's upper bound: never below the sample, at most 1/32 above.
TEST(Histogram, PercentilesAgreeWithSortedSamples) {
  std::mt19937_64 random(seedOf(3));
  for (const double spread : {0.5, 2.0, 4.0}) {
    Histogram h;
    std::lognormal_distribution<double> draw(9, spread);
    std::vector<std::uint64_t> all;
    for (int i = 0; i < 50'000; ++i) {
      all.push_back(static_cast<std::uint64_t>(std::min(draw(random), 4e9)));
      h.record(static_cast<std::int64_t>(all.back()));
    }
    std::sort(all.begin(), all.end());
    const auto s = h.summary();
    ASSERT_EQ(s.count, all.size());
    EXPECT_EQ(s.max_ns, all.back());
    const auto expectNear = [&](std::uint64_t got, std::size_t per_10000) {
      const std::uint64_t truth = all[(all.size() * per_10000 + 9999) / 10000 - 1];
      EXPECT_GE(got, truth) << per_10000;
      EXPECT_LE(got, truth + truth / Histogram::kSubBuckets + 1) << per_10000;
    };
    expectNear(s.p50_ns, 5000);
    expectNear(s.p99_ns, 9900);
    expectNear(s.p999_ns, 9990);
    expectNear(s.p9999_ns, 9999);
  }
}

TEST(Histogram, EveryPowerOfTwoAndItsNeighboursLandInOrder) {
  std::uint64_t before = 0;
  for (int power = 2; power < 32; ++power) {
    for (const int off : {-1, 0, 1}) {
      const std::int64_t value = (std::int64_t{1} << power) + off;
      Histogram h;
      h.record(value);
      h.record(std::int64_t{1} << 40);  // so that the bucket's own edge shows, not the maximum
      const auto s = h.summary();
      EXPECT_GE(s.p50_ns, static_cast<std::uint64_t>(value));
      EXPECT_GE(s.p50_ns, before);
      before = s.p50_ns;
    }
  }
}

TEST(Histogram, BeyondTheLastBucketOnlyTheMaximumIsExact) {
  Histogram h;
  h.record(std::int64_t{1} << 50);
  EXPECT_EQ(h.summary().max_ns, std::uint64_t{1} << 50);
  EXPECT_EQ(h.summary().p50_ns, std::uint64_t{1} << 50);
}

TEST(Histogram, ResetTakesEffectWithTheNextSample) {
  Histogram h;
  for (int i = 0; i < 100; ++i) h.record(1'000'000);
  h.requestReset();
  EXPECT_EQ(h.summary().count, 0u);
  h.record(10);
  const auto s = h.summary();
  EXPECT_EQ(s.count, 1u);
  EXPECT_EQ(s.max_ns, 10u);
}

}  // namespace
}  // namespace hapticd
