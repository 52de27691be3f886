// The motor heating estimate: closed forms, and its promises under any force whatever.
#include <gtest/gtest.h>

#include "property/random.h"
#include "rt/guard/heating.h"

namespace hapticd::test {
namespace {

constexpr double kDt = 1e-3;

/** A constant force below derating warms as 1 - exp(-t / tau). */
TEST(Heating, FollowsTheExponential) {
  Heating heating(4, 10, 30);
  for (int i = 0; i < 20'000; ++i) heating.book(3, kDt);
  EXPECT_NEAR(heating.heat(), 9.0 / 16 * (1 - std::exp(-20.0 / 30)), 1e-4);
  for (int i = 0; i < 60'000; ++i) heating.book(0, kDt);
  EXPECT_NEAR(heating.heat(), 9.0 / 16 * (1 - std::exp(-20.0 / 30)) * std::exp(-2.0), 1e-4);
}

/** Peak force lasts tau ln(r^2 / (r^2 - h)) until derating begins, r = peak / continuous, and is announced before. */
TEST(Heating, PeakLastsAsLongAsItShouldAndIsAnnouncedBefore) {
  Heating heating(3, 9, 30);
  double announced = -1;
  double derated = -1;
  for (int i = 0; derated < 0; ++i) {
    if (heating.allowed() < 9) derated = i * kDt;
    if (heating.warm() && announced < 0) announced = i * kDt;
    heating.book(9, kDt);
  }
  EXPECT_NEAR(announced, 30 * std::log(9 / (9 - Heating::kAnnounce)), 2e-2);
  EXPECT_NEAR(derated, 30 * std::log(9 / (9 - Heating::kDerate)), 2e-2);
}

TEST(Heating, ContinuousForceIsNeverCutAndNothingIsWithoutAModel) {
  Heating heating(3, 9, 5);
  for (int i = 0; i < 100'000; ++i) {
    heating.book(3, kDt);
    ASSERT_GE(heating.allowed(), 3);
  }
  EXPECT_NEAR(heating.heat(), 1, 1e-6);
  for (const Heating& none :
       {Heating(0, 9, 30), Heating(3, 3, 30), Heating(3, 9, 0), Heating(NAN, 9, 30), Heating(3, INFINITY, 1)}) {
    EXPECT_TRUE(std::isinf(none.allowed()));
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
                (peak - continuous) * kDt / tau / 0.15 * peak * peak / (continuous * continuous) * 1.01);
      announced = announced || heating.warm();
      if (allowed < peak) {
        ASSERT_TRUE(announced) << "cut without a word";
      }
      heating.book(std::isfinite(wanted) ? std::min(wanted, allowed) : allowed, kDt);
      ASSERT_LE(heating.heat(), 1 + 1e-12);
      before = allowed;
    }
  }
}

}  // namespace
}  // namespace hapticd::test
