#include "rt/guard/guard_limits.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapticd {
namespace {

constexpr double GuardLimits::*kFields[] = {
    &GuardLimits::force,         &GuardLimits::torque,   &GuardLimits::force_slew, &GuardLimits::torque_slew,
    &GuardLimits::gripper_force, &GuardLimits::velocity, &GuardLimits::power,      &GuardLimits::active_power};

GuardLimits each(double first) {
  GuardLimits limits;
  for (const auto field : kFields) limits.*field = first++;
  return limits;
}

TEST(GuardLimits, AnOrderCarriesEach) {
  const DeviceLimits order = limitsOrder(3, each(1), true);
  EXPECT_EQ(order.device, 3u);
  EXPECT_NE(order.only_lowers, 0u);
  EXPECT_EQ(limitsOrder(3, each(1), false).only_lowers, 0u);
  for (const auto field : kFields) EXPECT_EQ(limitsOf(order).*field, each(1).*field);
}

TEST(GuardLimits, EachIsLoweredByItself) {
  for (const auto field : kFields) {
    GuardLimits a = each(1);
    a.*field = 0.5;
    for (const auto other : kFields) {
      EXPECT_EQ(lower(a, each(1)).*other, a.*other);
      EXPECT_EQ(lower(each(1), a).*other, a.*other);
    }
  }
}

TEST(GuardLimits, WhatIsNoLimitIsSeenInEachAndNotLoweredAway) {
  for (const auto field : kFields) {
    for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      GuardLimits a = each(0);
      EXPECT_TRUE(valid(a));
      a.*field = bad;
      EXPECT_FALSE(valid(a));
      if (bad != std::numeric_limits<double>::infinity()) {
        EXPECT_FALSE(valid(lower(a, each(0))));
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
