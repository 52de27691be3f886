// Each limit of a device is the one that the program names: what holds a force back must not be another's number.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <hapticclient/hapticclient.hpp>
#include <string>
#include <vector>

#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

struct NamedLimit {
  const char* name;  ///< As the daemon calls it.
  double haptic_device_limits::*field;
};
constexpr NamedLimit kNamedLimits[] = {{"force", &haptic_device_limits::force},
                                       {"torque", &haptic_device_limits::torque},
                                       {"force_slew", &haptic_device_limits::force_slew},
                                       {"torque_slew", &haptic_device_limits::torque_slew},
                                       {"velocity", &haptic_device_limits::velocity},
                                       {"power", &haptic_device_limits::power},
                                       {"active_power", &haptic_device_limits::active_power},
                                       {"gripper_force", &haptic_device_limits::gripper_force}};

/** The number behind that name in a JSON object. */
double numberIn(const std::string& json, const std::string& name) {
  const std::size_t at = json.find('"' + name + "\":");
  return at == std::string::npos ? NAN : std::stod(json.substr(at + name.size() + 3));
}

TEST(DeviceLimitFields, EachIsLoweredByItself) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM, .device = "sim://default?dof=6&gripper=1"});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  auto client = haptic::Client::connect({daemon.adminSocket(), "administrator", true});
  ASSERT_TRUE(client) << client.error().message();
  const auto before = client->status();
  ASSERT_TRUE(before) << before.error().message();
  EXPECT_GT((*before)->devices[0]->limits->gripper_force, 0);
  const std::string path = std::string("/devices/") + (*before)->devices[0]->name + "/limits";
  haptic_device_limits want = *(*before)->devices[0]->limits;
  for (const NamedLimit& lowered : kNamedLimits) {
    SCOPED_TRACE(lowered.name);
    haptic_device_limits ask{};
    for (const NamedLimit& each : kNamedLimits) ask.*each.field = NAN;
    ask.*lowered.field = want.*lowered.field *= 0.75;
    const auto in_force = client->setLimits("", ask);
    ASSERT_TRUE(in_force) << in_force.error().message();
    const auto told = client->get(path);
    ASSERT_TRUE(told) << told.error().message();
    const auto status = client->status();
    ASSERT_TRUE(status) << status.error().message();
    for (const NamedLimit& each : kNamedLimits) {
      EXPECT_EQ((*in_force).*each.field, want.*each.field) << each.name;
      EXPECT_EQ(numberIn(*told, each.name), want.*each.field) << each.name << " of " << *told;
      EXPECT_EQ((*status)->devices[0]->limits->*each.field, want.*each.field) << each.name;
    }
  }
}

}  // namespace
}  // namespace hapticd::test
