#include "rt/body/share_search.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/random.h"

namespace hapticd {
namespace {

struct Found {
  double share = -1;
  int asked = 0;
};

template <class Excess>
Found search(double first, const Excess& excess) {
  ShareSearch s(first);
  Found found;
  do {
    found.share = s.share();
    ++found.asked;
  } while (s.next(excess(found.share)));
  EXPECT_EQ(found.share, s.share()) << "the answer is not what was asked for last";
  return found;
}

TEST(ShareSearch, WhatIsAllowedIsLeftAlone) {
  const Found found = search(0.8, [](double) { return -1e-12; });
  EXPECT_EQ(found.share, 0.8);
  EXPECT_EQ(found.asked, 1);
}

TEST(ShareSearch, EndsAtAStopWhereNothingIsAllowed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double excess : {1.0, nan}) {
    const Found found = search(1, [&](double) { return excess; });
    EXPECT_EQ(found.share, 0);
    EXPECT_EQ(found.asked, ShareSearch::kMostTries + 1);
  }
}

TEST(ShareSearch, KineticEnergyIsBroughtToItsBound) {
  // Of T s^2 <= allowed the answer is sqrt(allowed / T); where it is one rounding more than allowed, hardly less
  // than 1.
  for (const double allowed : {1 - 1e-16, 0.9999, 0.99, 0.7, 0.3, 0.05, 0.002}) {
    const Found found = search(1, [&](double s) { return s * s - allowed; });
    EXPECT_LE(found.share, std::sqrt(allowed));
    EXPECT_NEAR(found.share, std::sqrt(allowed), 1e-8) << allowed;
  }
}

TEST(ShareSearch, SpringsAreFollowedToo) {
  // a s^2 + b s <= allowed, by the quadratic's formula.
  Random random(seedOf(1));
  for (int i = 0; i < 10000; ++i) {
    const double a = random.in(0.1, 1), b = random.in(-1, 1), allowed = random.in(0, a + b);
    if (a + b < 0.01 || allowed < 0.01 * (a + b)) continue;
    const Found found = search(1, [&](double s) { return a * s * s + b * s - allowed; });
    const double exact = (std::sqrt(b * b + 4 * a * allowed) - b) / (2 * a);
    ASSERT_LE(found.share, exact * (1 + 1e-12)) << i;
    if (exact < 1.0 / 32) continue;  // May be a stop.
    ASSERT_GE(found.share, (1 - 1e-5) * exact) << i;
  }
}

TEST(ShareSearch, AnswersWhatIsAllowedWhateverItIsTold) {
  Random random(seedOf(2));
  for (int i = 0; i < 20000; ++i) {
    double last = 0;
    const Found found = search(random.in(0.01, 1), [&](double) {
      last = random.once(4) ? random.broken() : random.once(4) ? random.wild() : random.in(-1, 1);
      return last;
    });
    ASSERT_GE(found.share, 0);
    ASSERT_LE(found.share, 1);
    ASSERT_LE(found.asked, ShareSearch::kMostTries + ShareSearch::kRefinements + 1);
  }
}

}  // namespace
}  // namespace hapticd
