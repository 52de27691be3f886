#include "daemon/device/limits.h"

#include <gtest/gtest.h>

#include <limits>
#include <tuple>

namespace hapticd {
namespace {

DeviceInfo omega() {
  DeviceInfo info;
  info.max_force = 12;
  info.continuous_force = 8;
  info.max_velocity = 2;
  return info;
}

TEST(Limits, StartAtTheLowestOfConfigurationDeviceAndContinuousForce) {
  LimitsConfig config;
  config.force_n = 10;
  EXPECT_EQ(startLimits(config, omega()).force, 8) << "continuous";
  config.force_n = 5;
  EXPECT_EQ(startLimits(config, omega()).force, 5) << "configured";
  DeviceInfo weak = omega();
  weak.continuous_force = 0;
  weak.max_force = 3.3;
  EXPECT_EQ(startLimits(config, weak).force, 3.3) << "peak";
  DeviceInfo silent;
  EXPECT_EQ(startLimits(config, silent).force, 5) << "a device that says nothing is bound by the configuration";
  EXPECT_EQ(startLimits(config, omega()).velocity, 2);
  EXPECT_EQ(startLimits(config, omega()).torque, 0) << "no rotation is actuated";
  EXPECT_TRUE(valid(startLimits(config, silent)));
}

TEST(Limits, RaisingIsSeenInAnyField) {
  const GuardLimits a = startLimits({}, omega());
  EXPECT_FALSE(raises(a, a));
  for (double GuardLimits::*field :
       {&GuardLimits::force, &GuardLimits::torque, &GuardLimits::force_slew, &GuardLimits::torque_slew,
        &GuardLimits::gripper_force, &GuardLimits::velocity, &GuardLimits::power, &GuardLimits::active_power}) {
    GuardLimits b = a;
    b.*field += 0.1;
    EXPECT_TRUE(raises(b, a));
    EXPECT_FALSE(raises(a, b));
    EXPECT_TRUE(checkMaxima(a, b, "arm").ok());
    EXPECT_FALSE(checkMaxima(b, a, "arm").ok());
    b = a;
    b.*field = -1;
    EXPECT_FALSE(mergeLimits(a, b).ok());
    b.*field = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(mergeLimits(a, b).ok());
    b.*field = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ((*mergeLimits(a, b)).*field, a.*field);
  }
}

TEST(Limits, WhatIsFeltCanAlwaysFall) {
  const GuardLimits now = startLimits({}, omega());
  GuardLimits wanted = now;
  wanted.force_slew = 1;
  wanted.torque_slew = 0.1;
  EXPECT_TRUE(mergeLimits(now, wanted).ok()) << "as low as the configuration may have them";
  wanted.force_slew = 0;
  const auto none = mergeLimits(now, wanted);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(toString(none.error()),
            "limits.forceSlew: at 0 what the hand feels would hardly fall any more (1 to 1e+06; NaN keeps the limit "
            "that is in force)");
  wanted.force_slew = 1;
  wanted.torque_slew = 0.09;
  const auto little = mergeLimits(now, wanted);
  ASSERT_FALSE(little.ok());
  EXPECT_EQ(little.error().where, "limits.torqueSlew");
}

/** A number that the file may not have is a slip of the keyboard while it runs, too. */
TEST(Limits, WhatTheConfigurationMayNotSayNobodyMay) {
  const GuardLimits now = startLimits({}, omega());
  const std::tuple<double GuardLimits::*, double, double> ranges[] = {
      {&GuardLimits::force, 0, 200},         {&GuardLimits::torque, 0, 50},        {&GuardLimits::force_slew, 1, 1e6},
      {&GuardLimits::torque_slew, 0.1, 1e6}, {&GuardLimits::velocity, 0.01, 50},   {&GuardLimits::power, 0, 1000},
      {&GuardLimits::active_power, 0, 1000}, {&GuardLimits::gripper_force, 0, 200}};
  for (const auto& [field, least, most] : ranges) {
    for (const double good : {least, most}) {
      GuardLimits wanted = now;
      wanted.*field = good;
      EXPECT_TRUE(mergeLimits(now, wanted).ok()) << good;
    }
    for (const double bad : {least - 0.001, most * 1.001, 1e300}) {
      GuardLimits wanted = now;
      wanted.*field = bad;
      EXPECT_FALSE(mergeLimits(now, wanted).ok()) << bad;
    }
  }
  GuardLimits fast = now;
  fast.velocity = 1e300;
  EXPECT_EQ(toString(mergeLimits(now, fast).error()),
            "limits.velocity: 1e+300 is beyond what the configuration may say (0.01 to 50; NaN keeps the limit that is "
            "in force)");
}

/** What a device's own maxima have brought below the range stays, while another limit is changed. */
TEST(Limits, WhatStaysIsNotJudged) {
  GuardLimits now = startLimits({}, omega());
  now.velocity = 0.005;
  GuardLimits wanted = now;
  wanted.force = 1;
  EXPECT_TRUE(mergeLimits(now, wanted).ok());
}

TEST(Limits, WhatTheDeviceDoesNotAllowIsNamed) {
  GuardLimits wanted = startLimits({}, omega());
  wanted.gripper_force = 100;
  GuardLimits most = wanted;
  most.gripper_force = 8;
  EXPECT_EQ(toString(checkMaxima(wanted, most, "arm").error()),
            "limits.gripperForce: 100 is above what arm itself allows (at most 8)");
}

}  // namespace
}  // namespace hapticd
