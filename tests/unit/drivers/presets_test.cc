#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "drivers/sim/sim_parameters.h"

namespace hapticd {
namespace {

TEST(SimPresets, EachOpensByNameAndIsWithinTheTable) {
  std::set<std::string_view> names;
  for (const SimPreset& preset : simPresets()) {
    EXPECT_TRUE(names.insert(preset.name).second) << preset.name;
    Result<SimSetup> setup = resolveSim({"sim", std::string(preset.name), {}});
    ASSERT_TRUE(setup.ok()) << preset.name << ": " << toString(setup.error());
    EXPECT_EQ(setup->uri, fmt::format("sim://{}", preset.name));
    SimParameters p = preset.parameters;
    for (const Parameter<SimParameters>& parameter : simParameterTable()) {
      if (parameter.spec.key == "file" || parameter.spec.key == "serial") continue;
      const std::string text = formatParameter(parameter.slot(p));
      EXPECT_TRUE(setParameter(parameter.spec, parameter.slot(p), text).ok()) << preset.name << " " << text;
    }
  }
}

TEST(SimPresets, InformationIsCompleteAndConsistent) {
  for (const SimPreset& preset : simPresets()) {
    const DeviceInfo info = resolveSim({"sim", std::string(preset.name), {}})->info;
    SCOPED_TRACE(preset.name);
    EXPECT_FALSE(info.model.empty() || info.manufacturer.empty() || info.serial.empty());
    EXPECT_EQ(info.driver, "sim");
    EXPECT_GT(info.max_force, 0);
    EXPECT_LE(info.continuous_force, info.max_force);
    EXPECT_GT(info.max_stiffness, 100);
    EXPECT_GT(info.max_damping, 0);
    EXPECT_GT(info.workspace_radius, 0.03);
    EXPECT_TRUE((info.workspace_upper - info.workspace_lower).minCoeff() >= 2 * info.workspace_radius - 1e-12);
    EXPECT_GT(info.position_resolution, 0);
    EXPECT_GT(info.native_rate_hz, 0);
    EXPECT_GT(info.apparent_mass, 0);
    EXPECT_EQ(info.actuated_rotation, info.max_torque > 0);
    EXPECT_EQ(info.sensed_rotation, info.rotation_resolution > 0);
    EXPECT_EQ(info.actuated_rotation, info.max_angular_stiffness > 0);
    EXPECT_EQ(info.actuated_gripper, info.max_gripper_force > 0);
    EXPECT_EQ(info.sensed_gripper, info.gripper_max_angle > 0);
  }
}

TEST(SimPresets, EveryKeyIsWrittenToTheCanonicalUriAndReadBack) {
  // One value per key that differs from the default: the URI must carry each, and no other.
  for (const Parameter<SimParameters>& parameter : simParameterTable()) {
    const ParameterSpec& spec = parameter.spec;
    if (spec.key == "file") continue;  // Needs motion=csv.
    SimParameters p;
    const ParameterSlot slot = parameter.slot(p);
    std::string text;
    if (std::holds_alternative<bool*>(slot)) text = *std::get<bool*>(slot) ? "0" : "1";
    if (std::holds_alternative<double*>(slot)) {
      text = fmt::format("{}", *std::get<double*>(slot) * 0.75 + 0.25 * spec.highest);
    }
    if (std::holds_alternative<std::uint64_t*>(slot)) text = fmt::format("{}", std::uint64_t(spec.highest));
    if (std::holds_alternative<Vec3*>(slot)) {
      const Vec3 v = *std::get<Vec3*>(slot) * 0.5 + Vec3(0.125, 0.25, 0.375);
      text = fmt::format("{},{},{}", v.x(), v.y(), v.z());
    }
    if (std::holds_alternative<std::string*>(slot)) text = spec.choices.empty() ? "x y&z" : "circle";
    std::vector<std::pair<std::string, std::string>> query = {{std::string(spec.key), text}};
    if (spec.key == "lower") query.emplace_back("upper", "1,1,1");
    if (spec.key == "box_lower") query.emplace_back("box_upper", "1,1,1");

    Result<SimSetup> setup = resolveSim({"sim", "default", query});
    ASSERT_TRUE(setup.ok()) << spec.key << "=" << text << ": " << toString(setup.error());
    Result<DeviceUri> canonical = parseDeviceUri(setup->uri);
    ASSERT_TRUE(canonical.ok()) << setup->uri;
    EXPECT_EQ(canonical->query.size(), query.size()) << setup->uri;
    Result<SimSetup> again = resolveSim(*canonical);
    ASSERT_TRUE(again.ok()) << setup->uri;
    EXPECT_EQ(again->uri, setup->uri);
    EXPECT_EQ(again->info.serial, setup->info.serial);
  }
}

TEST(SimPresets, TremorComesWithMinimumJerkUnlessItIsSet) {
  EXPECT_EQ(resolveSim({"sim", "default", {{"motion", "minjerk"}}})->parameters.tremor, 1e-4);
  EXPECT_EQ(resolveSim({"sim", "default", {{"motion", "minjerk"}, {"tremor", "0"}}})->parameters.tremor, 0);
  EXPECT_EQ(resolveSim({"sim", "default", {{"motion", "hold"}}})->parameters.tremor, 0);
}

TEST(SimPresets, TheCanonicalUriKeepsATremorOfNothing) {
  Result<SimSetup> still = resolveSim({"sim", "default", {{"motion", "minjerk"}, {"tremor", "0"}}});
  ASSERT_TRUE(still.ok());
  EXPECT_EQ(resolveSim(*parseDeviceUri(still->uri))->parameters.tremor, 0) << still->uri;
}

}  // namespace
}  // namespace hapticd
