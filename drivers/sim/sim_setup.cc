/** @file
 * From a URI to everything a simulated device needs, checked as a whole.
 */
#include <fmt/format.h>

#include "drivers/number.h"
#include "drivers/sim/sim_parameters.h"

namespace hapticd {
namespace {

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

Result<MotionParameters> motionOf(const SimParameters& p) {
  MotionParameters m;
  m.kind = motionKind(p.motion);
  m.centre = p.centre;
  m.period = p.period;
  m.wait = p.wait;
  m.direction = p.direction;
  m.depth = p.depth;
  m.from = p.from;
  m.to = p.to;
  m.radius = p.radius;
  m.normal = p.normal;
  m.amplitude = p.amplitude;
  m.ratio = p.ratio;
  m.phase = p.phase;
  m.box_lower = p.box_lower;
  m.box_upper = p.box_upper;
  m.seed = p.seed;
  m.tremor = p.tremor;
  m.orientation = p.orientation;
  m.sway = p.sway;
  m.gripper = p.gripper_angle;
  m.loop = p.loop;
  if (m.kind == MotionKind::kCsv) {
    Result<std::shared_ptr<const PoseTrack>> track = loadPoseCsv(p.file);
    if (!track) return track.error();
    m.track = std::move(*track);
  }
  return m;
}

/** 64-bit FNV-1a. */
std::uint64_t hashOf(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

/**
 * Largest virtual wall that is passive for a device nobody holds, at 1 kHz and the device's own delay t_d:
 * K = b / (T/2 + t_d) by viscous friction (Colgate and Schenkel, J. Robotic Systems 14(1), 1997, with B = 0), or
 * K = 2 f_c / Delta by dry friction and encoder step Delta (Diolaiti, Niemeyer, Barbagli, Salisbury, IEEE Trans.
 * Robotics 22(2), 2006). A hand adds to it.
 */
double passiveStiffness(const SimParameters& p) {
  const double delay_s = static_cast<double>(p.delay + p.position_delay) / p.rate;
  const double viscous = p.viscous / (0.5e-3 + delay_s);
  const double dry = p.resolution > 0 ? 2 * p.coulomb / p.resolution : 0;
  return std::max(viscous, dry);
}

DeviceInfo infoOf(const SimSetup& setup) {
  const SimParameters& p = setup.parameters;
  DeviceInfo info;
  info.uri = setup.uri;
  info.model = fmt::format("{} (simulated)", setup.preset->model);
  info.manufacturer = setup.preset->manufacturer;
  info.serial = p.serial.empty() ? fmt::format("sim-{:016x}", hashOf(setup.uri)) : p.serial;
  info.firmware = "none";
  info.driver = "sim";
  info.driver_version = "1";
  const double half_s = 0.5e-3 + static_cast<double>(p.delay + p.position_delay) / p.rate;
  info.max_force = p.max_force;
  info.continuous_force = p.continuous_force;
  info.max_stiffness = p.max_stiffness > 0 ? p.max_stiffness : passiveStiffness(p);
  // A damper computed at 1 kHz from position differences turns the apparent mass unstable near m / (T/2 + t_d); half.
  info.max_damping = p.max_damping > 0 ? p.max_damping : 0.5 * p.mass / half_s;
  info.sensed_rotation = p.dof == 6 || p.sense_rotation;
  info.actuated_rotation = p.dof == 6;
  if (info.sensed_rotation) info.rotation_resolution = p.rotation_resolution;
  if (info.actuated_rotation) {
    info.max_torque = p.max_torque;
    info.max_angular_stiffness = std::max(
        p.angular_viscous / half_s, p.rotation_resolution > 0 ? 2 * p.angular_coulomb / p.rotation_resolution : 0.0);
    info.max_angular_damping = 0.5 * p.inertia / half_s;
  }
  info.sensed_gripper = info.actuated_gripper = p.gripper;
  if (p.gripper) {
    info.max_gripper_force = p.max_gripper_force;
    info.gripper_max_angle = p.gripper_max_angle;
    info.max_gripper_stiffness = 0.1 * p.gripper_mass / (half_s * half_s);
  }
  info.workspace_lower = info.max_workspace_lower = p.lower;
  info.workspace_upper = info.max_workspace_upper = p.upper;
  // The largest ball about the middle of the box.
  info.workspace_radius = (p.upper - p.lower).minCoeff() / 2;
  info.position_resolution = p.resolution;
  info.force_resolution = p.force_resolution;
  info.native_rate_hz = p.rate;
  info.apparent_mass = p.mass;
  info.viscous_friction = p.viscous;
  info.coulomb_friction = p.coulomb;
  info.buttons = static_cast<std::uint32_t>(p.buttons);
  info.servo_safe = true;
  return info;
}

}  // namespace

Result<SimSetup> resolveSim(const DeviceUri& uri) {
  Result<const SimPreset*> preset = presetOf(uri.authority);
  if (!preset) return preset.error();
  SimSetup setup;
  setup.preset = *preset;
  setup.parameters = setup.preset->parameters;
  Result<void> applied = applyQuery(simParameterTable(), uri.query, setup.parameters);
  if (!applied) return applied.error();
  bool tremor_given = false;
  for (const auto& [key, value] : uri.query) tremor_given = tremor_given || key == "tremor";
  // The tremor of a steady hand is of the order of 0.1 mm (Riviere, Rader, Khosla, IEEE EMBS 1997).
  if (setup.parameters.motion == "minjerk" && !tremor_given) setup.parameters.tremor = 1e-4;
  Result<void> checked = checkTogether(setup.parameters);
  if (!checked) return checked.error();
  Result<MotionParameters> motion = motionOf(setup.parameters);
  if (!motion) return motion.error();
  setup.motion = std::move(*motion);
  setup.uri = formatDeviceUri({"sim", std::string(setup.preset->name),
                               difference(simParameterTable(), setup.parameters, setup.preset->parameters)});
  setup.info = infoOf(setup);
  return setup;
}

}  // namespace hapticd
