#include "drivers/vendor/vendor_parameters.h"

#include <charconv>

#include "drivers/vendor/sdk/dhd_sdk.h"

namespace hapticd {
namespace {

/** Published figures of a family; CHAI3D's where the maker gives none. Half the sides of a box that is used well. */
struct DhdFamily {
  int from, to;  ///< System types.
  double force, torque, gripper_force, stiffness, damping;
  Vec3 half;
};
const DhdFamily kFamilies[] = {
    {63, 64, 20, 0.15, 0, 5000, 20, {0.10, 0.14, 0.14}},   // delta
    {33, 37, 12, 0, 8, 5000, 30, {0.04, 0.06, 0.05}},      // omega
    {104, 107, 20, 0.4, 8, 4000, 30, {0.04, 0.07, 0.05}},  // sigma
    {108, 109, 20, 0.2, 8, 8000, 30, {0.05, 0.08, 0.08}},  // lambda
    {60, 60, 8, 0, 0, 3000, 20, {0.03, 0.03, 0.03}},       // Novint's Falcon
};
constexpr double kJaws_rad = 30 * EIGEN_PI / 180;  ///< CHAI3D's for all that have a gripper.
const DhdFamily kUnknown = {0, 0, 5, 0.1, 4, 1000, 5, {0.03, 0.03, 0.03}};

void fill(const DhdFamily& family, DeviceInfo& info) {
  info.max_force = family.force;
  info.max_torque = family.torque;
  info.max_gripper_force = family.gripper_force;
  info.gripper_max_angle = kJaws_rad;
  info.max_stiffness = family.stiffness;
  info.max_damping = family.damping;
  info.workspace_lower = -family.half;
  info.workspace_upper = family.half;
  info.workspace_radius = family.half.minCoeff();
  info.max_workspace_lower = -2.5 * family.half;
  info.max_workspace_upper = 2.5 * family.half;
}

DeviceInfo common(const char* driver, const char* manufacturer, const char* model) {
  DeviceInfo info;
  info.driver = driver;
  info.driver_version = "1";
  info.manufacturer = manufacturer;
  info.model = model;
  info.position_resolution = 30e-6;
  info.force_resolution = 0.01;
  info.native_rate_hz = 1000;
  info.latency_s = 0.002;
  return info;
}

}  // namespace

void describeDhd(int system_type, DeviceInfo& info) {
  for (const DhdFamily& family : kFamilies) {
    if (system_type >= family.from && system_type <= family.to) return fill(family, info);
  }
  fill(kUnknown, info);
}

const std::vector<Parameter<DhdParameters>>& dhdParameterTable() {
  using S = DhdParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"sdk", "", 0, 0, "Library of the vendor's SDK: a path, or a name where the system's loader looks."}, &S::sdk},
      {{"serial", "", 0, 65'535, "Its serial number, if there are several; 0: whichever the SDK takes."}, &S::serial},
      {{"gravity", "", 0, 1, "The SDK carries the arm's weight while forces are on, past hapticd's guard."},
       &S::gravity},
  };
  return kTable;
}

Result<DhdSetup> resolveDhd(const DeviceUri& uri) {
  DhdSetup setup;
  if (auto applied = applyQuery(dhdParameterTable(), uri.query, setup.parameters); !applied) return applied.error();
  const std::string& place = uri.authority;
  if (!place.empty() && place != "default") {
    const auto [end, bad] = std::from_chars(place.data(), place.data() + place.size(), setup.index);
    if (bad != std::errc() || end != place.data() + place.size() || setup.index < 0 || setup.index > 63) {
      return Error{ErrorCode::kInvalidArgument, "dhd://" + place, "a device is counted from 0 to 63, or is the default",
                   "write dhd://default, dhd://0 or dhd://default?serial=NUMBER"};
    }
  }
  setup.info = common("dhd", "Force Dimension", "unknown until it is open");
  fill(kUnknown, setup.info);
  setup.info.calibration_style = "as its manual says: with the SDK's own programs, or by its button";
  setup.info.has_brakes = true;
  setup.info.buttons = DhdSdk::kMostButtons;
  setup.info.has_velocity_limit = true;
  setup.info.uri = formatDeviceUri({"dhd", setup.index < 0 ? "default" : std::to_string(setup.index),
                                    difference(dhdParameterTable(), setup.parameters, {})});
  return setup;
}

const std::vector<Parameter<HdParameters>>& hdParameterTable() {
  using S = HdParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"sdk", "", 0, 0, "Library of the vendor's SDK: a path, or a name where the system's loader looks."}, &S::sdk},
  };
  return kTable;
}

Result<HdSetup> resolveHd(const DeviceUri& uri) {
  HdSetup setup;
  if (auto applied = applyQuery(hdParameterTable(), uri.query, setup.parameters); !applied) return applied.error();
  const bool any = uri.authority.empty() || uri.authority == "default" || uri.authority == "Default";
  if (!any) setup.device = uri.authority;
  DeviceInfo& info = setup.info = common("openhaptics", "3D Systems", "unknown until it is open");
  // Of the weakest, the Touch; the device tells better ones when it is open.
  info.max_force = 3.3;
  info.continuous_force = 0.88;
  info.max_stiffness = 400;
  info.max_damping = 2;
  info.workspace_lower = Vec3(-0.035, -0.08, -0.06);
  info.workspace_upper = Vec3(0.035, 0.08, 0.06);
  info.max_workspace_lower = Vec3(-0.2, -0.3, -0.3);
  info.max_workspace_upper = Vec3(0.3, 0.3, 0.4);
  info.workspace_radius = 0.035;
  info.sensed_rotation = true;
  info.buttons = 2;
  info.calibration_style = "put the stylus into the inkwell, or as the maker's set-up program says";
  info.uri = formatDeviceUri(
      {"openhaptics", any ? "default" : setup.device, difference(hdParameterTable(), setup.parameters, {})});
  return setup;
}

}  // namespace hapticd
