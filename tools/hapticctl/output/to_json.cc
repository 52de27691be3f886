#include "tools/hapticctl/output/to_json.h"

#include "tools/hapticctl/daemon.h"

namespace hapticctl {
namespace {

template <class Number, std::size_t n>
Json array(const Number (&values)[n]) {
  Json out = Json::array();
  for (const Number value : values) out.push_back(value);
  return out;
}

Json abilities(std::uint32_t bits) {
  constexpr const char* kNames[] = {"senses_position",   "senses_rotation",   "senses_gripper",
                                    "actuates_position", "actuates_rotation", "actuates_gripper",
                                    "left_hand",         "right_hand",        "brakes",
                                    "watchdog",          "deadman",           "velocity_limit"};
  Json out = Json::array();
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if ((bits >> i & 1u) != 0) out.push_back(kNames[i]);
  }
  return out;
}

}  // namespace

Json toJson(const haptic_pose& pose) { return {{"p", array(pose.p)}, {"q", array(pose.q)}}; }

Json toJson(const haptic_daemon_info& info) {
  return {{"version", info.version},
          {"pid", info.pid},
          {"protocol", std::to_string(info.protocol_major) + "." + std::to_string(info.protocol_minor)},
          {"epoch", info.epoch},
          {"administration", info.administration != 0},
          {"realtime", info.realtime != 0},
          {"scheduling_note", info.scheduling_note},
          {"socket", info.socket},
          {"config_file", info.config_file},
          {"started_ns", info.started_ns}};
}

Json toJson(const haptic_device_info& d) {
  constexpr const char* kCalibration[] = {"not needed", "needed", "running", "done"};
  return {{"uri", d.uri},
          {"name", d.name},
          {"open", d.open != 0},
          {"model", d.model},
          {"manufacturer", d.manufacturer},
          {"serial", d.serial},
          {"firmware", d.firmware},
          {"driver", d.driver},
          {"driver_version", d.driver_version},
          {"abilities", abilities(d.abilities)},
          {"buttons", d.buttons},
          {"calibration", d.calibration < 4 ? kCalibration[d.calibration] : "unknown"},
          {"calibration_style", d.calibration_style},
          {"max_force", d.max_force},
          {"continuous_force", d.continuous_force},
          {"max_torque", d.max_torque},
          {"max_gripper_force", d.max_gripper_force},
          {"max_stiffness", d.max_stiffness},
          {"max_angular_stiffness", d.max_angular_stiffness},
          {"max_gripper_stiffness", d.max_gripper_stiffness},
          {"max_damping", d.max_damping},
          {"max_angular_damping", d.max_angular_damping},
          {"workspace_radius", d.workspace_radius},
          {"workspace_lower", array(d.workspace_lower)},
          {"workspace_upper", array(d.workspace_upper)},
          {"max_workspace_lower", array(d.max_workspace_lower)},
          {"max_workspace_upper", array(d.max_workspace_upper)},
          {"gripper_max_angle", d.gripper_max_angle},
          {"position_resolution", d.position_resolution},
          {"rotation_resolution", d.rotation_resolution},
          {"force_resolution", d.force_resolution},
          {"native_rate_hz", d.native_rate_hz},
          {"apparent_mass", d.apparent_mass},
          {"viscous_friction", d.viscous_friction},
          {"coulomb_friction", d.coulomb_friction},
          {"max_velocity", d.max_velocity},
          {"temperature_c", d.temperature_c},
          {"problem", d.problem}};
}

Json toJson(const haptic_device_limits& limits) {
  return {{"force", limits.force},
          {"torque", limits.torque},
          {"force_slew", limits.force_slew},
          {"torque_slew", limits.torque_slew},
          {"velocity", limits.velocity},
          {"power", limits.power},
          {"active_power", limits.active_power},
          {"gripper_force", limits.gripper_force}};
}

Json toJson(const haptic_device_status& d) {
  return {{"uri", d.uri},
          {"name", d.name},
          {"armed", d.armed != 0},
          {"fault", d.fault},
          {"fault_text", d.fault_text},
          {"lease_holder", d.lease_holder},
          {"lease_pid", d.lease_pid},
          {"group", d.group},
          {"scheduling", d.scheduling},
          {"rate_hz", d.rate_hz},
          {"cycles", d.cycles},
          {"missed", d.missed},
          {"stale", d.stale},
          {"busy", d.busy},
          {"wake_p99_ns", d.wake_p99_ns},
          {"limits", toJson(*d.limits)},
          {"pose", toJson(d.pose)},
          {"force", array(d.force)}};
}

Json toJson(const haptic_client_status& c) {
  return {{"session", c.session},   {"name", c.name},         {"pid", c.pid},
          {"uid", c.uid},           {"device", c.device},     {"lease", c.lease != 0},
          {"received", c.received}, {"rejected", c.rejected}, {"stale", c.stale},
          {"models", c.models},     {"fade", c.fade},         {"heartbeat_age_ns", c.heartbeat_age_ns},
          {"bytes", c.bytes}};
}

Json toJson(const haptic_status& status) {
  Json devices = Json::array();
  Json clients = Json::array();
  for (std::uint32_t i = 0; i < status.device_count; ++i) devices.push_back(toJson(*status.devices[i]));
  for (std::uint32_t i = 0; i < status.client_count; ++i) clients.push_back(toJson(*status.clients[i]));
  return {{"daemon", toJson(*status.info)}, {"devices", std::move(devices)}, {"clients", std::move(clients)},
          {"objects", status.objects},      {"triangles", status.triangles}, {"locked_bytes", status.locked_bytes},
          {"uptime_ns", status.uptime_ns}};
}

Json toJson(const haptic_statistics& s) {
  Json histograms = Json::object();
  for (std::uint32_t i = 0; i < s.histogram_count; ++i) {
    const haptic_histogram& h = *s.histograms[i];
    histograms[h.name] = {{"count", h.count},     {"p50_ns", h.p50_ns},     {"p99_ns", h.p99_ns},
                          {"p999_ns", h.p999_ns}, {"p9999_ns", h.p9999_ns}, {"max_ns", h.max_ns}};
  }
  return {{"uri", s.uri},
          {"period_ns", s.period_ns},
          {"cycles", s.cycles},
          {"missed", s.missed},
          {"overruns", s.overruns},
          {"stale_samples", s.stale_samples},
          {"collide_queries", s.collide_queries},
          {"collide_exhausted", s.collide_exhausted},
          {"collide_unsent", s.collide_unsent},
          {"histograms", std::move(histograms)}};
}

Json toJson(const haptic_sample& s) {
  constexpr const char* kSources[HAPTIC_SOURCES] = {"surface", "effect",  "local_model", "client",
                                                    "gravity", "texture", "transient",   "guard"};
  Json by_source = Json::object();
  for (std::size_t i = 0; i < HAPTIC_SOURCES; ++i) by_source[kSources[i]] = array(s.by_source[i]);
  return {{"t_ns", s.t_ns},
          {"tick", s.tick},
          {"p", array(s.p)},
          {"q", array(s.q)},
          {"v", array(s.v)},
          {"w", array(s.w)},
          {"proxy", array(s.proxy)},
          {"force", array(s.force)},
          {"torque", array(s.torque)},
          {"by_source", std::move(by_source)},
          {"own", array(s.own)},
          {"gripper_rad", s.gripper_rad},
          {"gripper_force_n", s.gripper_force_n},
          {"energy_j", s.energy_j},
          {"depth_m", s.depth_m},
          {"contact_object", s.contact_object},
          {"buttons", s.buttons},
          {"flags", s.flags},
          {"fault", faultName(s.fault)},
          {"missed", s.missed},
          {"wake_ns", s.wake_ns},
          {"cycle_ns", s.cycle_ns}};
}

Json toJson(const haptic_event& e) {
  return {{"kind", haptic_event_name(e.kind)},
          {"t_ns", e.t_ns},
          {"tick", e.tick},
          {"device", e.device},
          {"object", e.object},
          {"session", e.session},
          {"value", e.value},
          {"point", array(e.point)},
          {"force", e.force},
          {"text", e.text},
          {"lost", e.lost}};
}

Json toJson(const haptic_mesh_report& r) {
  Json notes = Json::array();
  for (std::uint32_t i = 0; i < r.note_count; ++i) notes.push_back(r.notes[i]);
  return {{"mesh", r.id},
          {"vertices", r.vertices},
          {"triangles", r.triangles},
          {"bytes", r.bytes},
          {"lower", array(r.lower)},
          {"upper", array(r.upper)},
          {"closed", r.closed != 0},
          {"build_ns", r.build_ns},
          {"notes", std::move(notes)}};
}

}  // namespace hapticctl
