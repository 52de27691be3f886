/** @file
 * From a URI to everything a simulated device needs, checked as a whole.
 */
#include <fmt/format.h>

#include <algorithm>

#include "drivers/did_you_mean.h"
#include "drivers/hash.h"
#include "drivers/sim/sim_parameters.h"

namespace hapticd {
namespace {

/** Tremor that comes with minimum-jerk reaches: a steady hand's is of this order (Riviere, Rader, Khosla 1997). */
constexpr double kHandTremor_m = 1e-4;

Error fault(std::string_view key, std::string what, std::string remedy) {
  return {ErrorCode::kInvalidArgument, fmt::format("device URI, key {}", key), std::move(what), std::move(remedy)};
}

Result<const SimPreset*> presetOf(std::string_view name) {
  std::vector<std::string_view> names;
  for (const SimPreset& preset : simPresets()) {
    if (preset.name == name) return &preset;
    names.push_back(preset.name);
  }
  if (name.empty()) return &simPresets().front();
  const std::string_view near = nearest(name, names);
  return Error{
      ErrorCode::kNotFound, "device URI", fmt::format("there is no simulated device \"{}\"", name),
      near.empty() ? fmt::format("there are {}", fmt::join(names, ", ")) : fmt::format("did you mean sim://{}?", near)};
}

Result<void> checkTogether(const SimParameters& p) {
  if (p.dof != 3 && p.dof != 6) return fault("dof", fmt::format("{} is not possible", p.dof), "3 or 6");
  for (int i = 0; i < 3; ++i) {
    if (p.upper[i] - p.lower[i] < 1e-3) {
      return fault("upper", "the workspace is empty", "upper must exceed lower by 1 mm on each axis");
    }
    if (p.box_upper[i] < p.box_lower[i]) {
      return fault("box_upper", "the box of targets is inside out", "box_upper must not be below box_lower");
    }
  }
  if (p.direction.norm() < 1e-6) return fault("direction", "a direction of length 0", "give a vector, e.g. 0,0,-1");
  if (p.normal.norm() < 1e-6) return fault("normal", "a normal of length 0", "give a vector, e.g. 0,0,1");
  if (p.motion == "csv" && p.file.empty()) {
    return fault("file", "motion=csv needs a file", "add file=/path/to/motion.csv");
  }
  if (p.motion != "csv" && !p.file.empty()) {
    return fault("file", fmt::format("motion={} reads no file", p.motion), "add motion=csv");
  }
  if (p.gripper_angle > p.gripper_max_angle && p.gripper) {
    return fault("gripper_angle", "more than gripper_max_angle", "lower it");
  }
  return {};
}

double latency(const SimParameters& p) { return static_cast<double>(p.delay + p.position_delay) / p.rate; }
/** Half of a host period at 1 kHz, on average what a held force lags by, and the device's own delay [s]. */
double lag(const SimParameters& p) { return 0.5e-3 + latency(p); }

/**
 * Half of the stiffest virtual wall, K = (b + B) / (T/2 + t_d), that stays stable at T = 1 ms with the damping b of the
 * device and B of the hand and a delay t_d (Gil, Sanchez, Hulin, Preusche, Hirzinger, J. Computing and Information
 * Science in Engineering 9(1), 2009). Dry friction adds to it and is left out.
 */
double wallStiffness(double device_damping, double hand_damping, double lag_s) {
  return 0.5 * (device_damping + hand_damping) / lag_s;
}

/**
 * Half of the strongest virtual damper that leaves a mass m stable when velocity is the difference of two samples:
 * B = m / (T/2 + t_d), which for t_d = 0 is the exact 2 m / T. But no more than lets one encoder step in one
 * millisecond push with a twentieth of the largest force, else the damper is felt as a buzz.
 */
double virtualDamping(double mass, double lag_s, double max_force, double resolution) {
  const double stable = 0.5 * mass / lag_s;
  return resolution > 0 ? std::min(stable, 0.05 * max_force * 1e-3 / resolution) : stable;
}

DeviceInfo infoOf(const SimSetup& setup) {
  const SimParameters& p = setup.parameters;
  DeviceInfo info;
  info.uri = setup.uri;
  info.model = fmt::format("{} (simulated)", setup.preset->model);
  info.manufacturer = setup.preset->manufacturer;
  info.serial = p.serial.empty() ? "sim-" + hashText(setup.uri) : p.serial;
  info.firmware = "none";
  info.driver = "sim";
  info.driver_version = "1";
  const double lag_s = lag(p);
  info.max_force = p.max_force;
  info.continuous_force = p.continuous_force;
  info.max_stiffness = p.max_stiffness > 0 ? p.max_stiffness : wallStiffness(p.viscous, p.hand_damping, lag_s);
  info.max_damping =
      p.max_damping > 0 ? p.max_damping : virtualDamping(p.mass + p.hand_mass, lag_s, p.max_force, p.resolution);
  info.sensed_rotation = p.dof == 6 || p.sense_rotation;
  info.actuated_rotation = p.dof == 6;
  if (info.sensed_rotation) info.rotation_resolution = p.rotation_resolution;
  if (info.actuated_rotation) {
    info.max_torque = p.max_torque;
    info.max_angular_stiffness = wallStiffness(p.angular_viscous, p.hand_angular_damping, lag_s);
    info.max_angular_damping = virtualDamping(p.inertia + p.hand_inertia, lag_s, p.max_torque, p.rotation_resolution);
  }
  info.sensed_gripper = info.actuated_gripper = p.gripper;
  if (p.gripper) {
    info.max_gripper_force = p.max_gripper_force;
    info.gripper_max_angle = p.gripper_max_angle;
    info.max_gripper_stiffness = wallStiffness(0, p.hand_pinch_damping, lag_s);
  }
  info.workspace_lower = info.max_workspace_lower = p.lower;
  info.workspace_upper = info.max_workspace_upper = p.upper;
  // The largest ball about the middle of the box.
  info.workspace_radius = (p.upper - p.lower).minCoeff() / 2;
  info.position_resolution = p.resolution;
  info.force_resolution = p.force_resolution;
  info.native_rate_hz = p.rate;
  info.latency_s = latency(p);
  info.apparent_mass = p.mass;
  info.viscous_friction = p.viscous;
  info.coulomb_friction = p.coulomb;
  info.buttons = static_cast<std::uint32_t>(p.buttons);
  return info;
}

}  // namespace

Result<SimSetup> resolveSim(const DeviceUri& uri) {
  Result<const SimPreset*> preset = presetOf(uri.authority);
  if (!preset) return preset.error();
  SimSetup setup;
  setup.preset = *preset;
  SimParameters base = setup.preset->parameters;
  for (const auto& [key, value] : uri.query) {
    if (key == "motion" && value == "minjerk") base.tremor = kHandTremor_m;
  }
  setup.parameters = base;
  Result<void> applied = applyQuery(simParameterTable(), uri.query, setup.parameters);
  if (!applied) return applied.error();
  Result<void> checked = checkTogether(setup.parameters);
  if (!checked) return checked.error();
  setup.parameters.kind = motionKind(setup.parameters.motion);
  if (setup.parameters.kind == MotionKind::kCsv) {
    Result<PoseFile> file = PoseFile::open(setup.parameters.file, uri.within);
    if (!file) return file.error();
    setup.file = std::move(*file);
  }
  setup.uri = formatDeviceUri(
      {"sim", std::string(setup.preset->name), difference(simParameterTable(), setup.parameters, base)});
  setup.info = infoOf(setup);
  return setup;
}

}  // namespace hapticd
