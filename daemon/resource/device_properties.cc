#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "daemon/device/finger_words.h"
#include "daemon/device/mount.h"
#include "daemon/resource/properties.h"
#include "daemon/resource/resource_name.h"
#include "drivers/link/has_battery.h"

namespace hapticd {
namespace {

Json getInfo(const OpenDevice& device, const DeviceNow&, Core&) {
  const DeviceInfo& i = device.info();
  return {{"model", i.model},
          {"manufacturer", i.manufacturer},
          {"serial", i.serial},
          {"firmware", i.firmware},
          {"driver", i.driver},
          {"driver_version", i.driver_version},
          {"max_force", number(i.max_force)},
          {"continuous_force", number(i.continuous_force)},
          {"max_torque", number(i.max_torque)},
          {"max_stiffness", number(i.max_stiffness)},
          {"max_damping", number(i.max_damping)},
          {"workspace_radius", number(i.workspace_radius)},
          {"workspace_lower", toJson(i.workspace_lower)},
          {"workspace_upper", toJson(i.workspace_upper)},
          {"position_resolution", number(i.position_resolution)},
          {"force_resolution", number(i.force_resolution)},
          {"native_rate_hz", number(i.native_rate_hz)},
          {"buttons", i.buttons}};
}

Json getLease(const OpenDevice& device, const DeviceNow&, Core& core) {
  const Session* holder = device.lease == 0 ? nullptr : core.sessions().find(device.lease);
  if (holder == nullptr) return nullptr;
  return {{"session", holder->id}, {"client", holder->client.name}, {"pid", holder->client.pid}};
}

Json getBySource(const OpenDevice&, const DeviceNow& s, Core&) {
  static constexpr const char* kNames[HD_SOURCES] = {"surface", "effect",  "local_model", "client",
                                                     "gravity", "texture", "transient",   "guard"};
  Json json;
  for (std::uint32_t i = 0; i < HD_SOURCES; ++i) {
    const float* f = s.sample.by_source[i];
    json[kNames[i]] = {number(f[0]), number(f[1]), number(f[2])};
  }
  return json;
}

Json getCounts(const OpenDevice&, const DeviceNow& s, Core&) {
  return {{"cycles", s.cycles}, {"missed", s.missed}, {"overruns", s.overruns}, {"stale", s.stale}};
}

Json getRoundTrip(const OpenDevice& device, const DeviceNow&, Core&) {
  const Histogram* histogram = device.link->group().device(device.index).roundTrip();
  if (histogram == nullptr) return nullptr;
  const Histogram::Summary s = histogram->summary();
  constexpr double kUsPerNs = 1e-3;
  return {{"count", s.count},
          {"p50", static_cast<double>(s.p50_ns) * kUsPerNs},
          {"p99", static_cast<double>(s.p99_ns) * kUsPerNs},
          {"max", static_cast<double>(s.max_ns) * kUsPerNs}};
}

Result<void> setRadius(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                       const Client& by) {
  auto n = parseNumbers(value, 1, where);
  if (!n) return n.error();
  return core.setRadius(device, n->front(), by);
}

Json getTool(const OpenDevice& device, const DeviceNow&, Core& core) {
  const HeldObject& tool = device.tool;
  const auto& contacts = device.link->group().colliderCounters().contacts[device.index];
  if (tool.object.empty() || core.scene().nameOf(tool.id) != tool.object) return nullptr;  // gone with its object
  return {{"object", tool.object},
          {"mass", number(tool.mass)},
          {"stiffness", number(tool.stiffness)},
          {"torque_shown", tool.shows_torque},
          {"weight", tool.weighs ? "felt" : "compensated"},
          {"rendering", tool.direct ? "direct" : "coupled"},
          {"contacts", contacts.load(std::memory_order_relaxed)},
          {"note", tool.note}};
}

/** OBJECT[,MASS[,STIFFNESS]] and then any of the words `weighs` and `direct`; nothing takes it away. */
Result<void> setTool(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                     const Client& by) {
  if (value.empty()) return core.detachTool(device, by);
  ToolWish wish;
  wish.object = std::string(value.substr(0, value.find(',')));
  std::vector<double*> numbers{&wish.stiffness, &wish.mass};  // Those that may still come, the next one last.
  for (std::string_view rest = value.substr(wish.object.size()); !rest.empty();) {
    const std::string_view word = rest.substr(1, rest.find(',', 1) - 1);
    rest.remove_prefix(1 + word.size());
    if (word == "weighs" || word == "direct") {
      (word == "weighs" ? wish.weighs : wish.direct) = true;
      numbers.clear();
      continue;
    }
    const auto parsed = parseNumbers(word, 1, where);
    if (!parsed || numbers.empty()) {
      return Error{
          ErrorCode::kInvalidArgument, where, fmt::format("'{}' cannot stand there", word.substr(0, 40)),
          "write the object, kg, N/m, and the words weighs and direct, as far as wanted: stick,0.1,500,weighs"};
    }
    *numbers.back() = parsed->front();
    numbers.pop_back();
  }
  return core.attachTool(device, wish, by);
}

Json getGrip(const OpenDevice& device, const DeviceNow& s, Core&) {
  if (!(device.grip.stiffness > 0)) return nullptr;
  return {{"stiffness", number(device.grip.stiffness)},
          {"width", number(device.grip.width)},
          {"angle", number(s.sample.gripper_rad)},
          {"force", number(s.sample.gripper_force_n)}};
}

/** STIFFNESS,WIDTH; nothing lets it close freely. */
Result<void> setGrip(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                     const Client& by) {
  if (value.empty()) return core.setGrip(device, 0, 0, by);
  auto n = parseNumbers(value, 2, where);
  if (!n) return n.error();
  return core.setGrip(device, n->front(), n->back(), by);
}

Json getFinger(const OpenDevice& device, const DeviceNow&, Core&) {
  const SetFinger& finger = device.finger;
  if (finger.law == 0) return nullptr;
  return {{"law", fingerLaw(finger)},
          {"coupled", (finger.flags & kFingerUncoupled) == 0},
          {"arm", number(finger.arm)},
          {"radius", number(finger.radius)},
          {"stiffness", number(finger.stiffness)},
          {"damping", number(finger.damping)},
          {"cue", number(finger.cue)},
          {"torque_shown", finger.shows_moment != 0}};
}

/** As parseFinger() has it; "none" or nothing is a point again. */
Result<void> setFinger(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                       const Client& by) {
  const auto finger = parseFinger(value, where);
  if (!finger) return finger.error();
  return core.setFinger(device, *finger, by);
}

Json getMount(const OpenDevice& device, const DeviceNow&, Core&) {
  Json json = toJson(device.mount.pose());
  json["deg"] = toJson(toDegrees(device.mount.pose().q));
  return json;
}

/** X,Y,Z and then three turns in degrees or a quaternion, if there are any; nothing is the world's frame. */
Result<void> setMount(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                      const Client& by) {
  if (value.empty()) return core.setMount(device, {}, by);
  const auto count = static_cast<std::size_t>(std::count(value.begin(), value.end(), ',')) + 1;
  if (count != 3 && count != 6 && count != 7) {
    return Error{ErrorCode::kInvalidArgument, where, fmt::format("a place does not have {} numbers", count),
                 "x,y,z [m], then turns about x, y and z [deg] or a quaternion w,x,y,z: 0.3,0,0,0,0,90"};
  }
  auto parsed = parseNumbers(value, count, where);
  if (!parsed) return parsed.error();
  const std::vector<double>& n = *parsed;
  Pose X_WD{{n[0], n[1], n[2]}, Quat::Identity()};
  if (count == 7) X_WD.q = Quat(n[3], n[4], n[5], n[6]);
  if (count == 6) {
    const Vec3 turns(n[3], n[4], n[5]);
    if (!(turns.cwiseAbs().maxCoeff() <= 360)) {
      return Error{ErrorCode::kInvalidArgument, where, "a turn is by 360 degrees at most", "for example 0,0,90"};
    }
    X_WD.q = fromDegrees(turns);
  }
  return core.setMount(device, X_WD, by);
}

/** What of the device is scaled, too. */
Json getScale(const OpenDevice& device, const DeviceNow&, Core&) {
  const DeviceInfo& info = device.info();
  const double s = device.mount.scale();
  const auto known = [](double x) { return x > 0 ? number(x) : Json(nullptr); };
  return {{"scale", number(s)},
          {"workspace_radius", known(s * info.workspace_radius)},
          {"position_resolution", known(s * info.position_resolution)},
          {"max_stiffness", known(info.max_stiffness / s)},
          {"max_damping", known(info.max_damping / s)}};
}

/** A number; or, with `m` behind it, the radius that the workspace is to have in the world. Nothing is 1. */
Result<void> setScale(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                      const Client& by) {
  if (value.empty()) return core.setScale(device, 1, by);
  const bool radius = value.ends_with('m');
  auto n = parseNumbers(value.substr(0, value.size() - (radius ? 1 : 0)), 1, where);
  if (!n) {
    return Error{ErrorCode::kInvalidArgument, where, fmt::format("'{}' is no scale", value.substr(0, 40)),
                 "write metres of the world for one of the hand, as 5; or, as 0.5m, the radius of its workspace there"};
  }
  const double own = device.info().workspace_radius;
  if (radius && !(own > 0)) {
    return Error{ErrorCode::kUnsupported, where, "how large its workspace is, the device does not say",
                 "give the scale itself: metres of the world for one of the hand"};
  }
  return core.setScale(device, radius ? n->front() / own : n->front(), by);
}

Json getClutch(const OpenDevice& device, const DeviceNow& s, Core&) {
  return {{"held", device.clutch_held},
          {"button", device.clutch_button == 0 ? Json(nullptr) : Json(device.clutch_button)},
          {"off", (s.sample.flags & HD_SAMPLE_CLUTCHED) != 0}};
}

/** The word `held` or `released`, or the number of a button, 0 for none. */
Result<void> setClutch(Core& core, OpenDevice& device, std::string_view value, const std::string& where,
                       const Client& by) {
  if (value == "held" || value == "released") return core.setClutch(device, value == "held", device.clutch_button, by);
  auto n = parseNumbers(value, 1, where);
  if (!n || !(n->front() >= 0 && n->front() <= 32) || n->front() != std::floor(n->front())) {
    return Error{ErrorCode::kInvalidArgument, where, fmt::format("'{}' is no button of a clutch", value.substr(0, 40)),
                 "write held or released, or the button that holds it: 1 is the first, 0 binds none"};
  }
  return core.setClutch(device, device.clutch_held, static_cast<std::uint32_t>(n->front()), by);
}

constexpr DeviceProperty kDeviceProperties[] = {
    {"uri", "opens this device and no other",
     [](const OpenDevice& d, const DeviceNow&, Core&) { return Json(d.info().uri); }},
    {"info", "what it is and can do", getInfo},
    {"pos", "device point in the world [m]",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return toJson(vec3(s.sample.p)); }},
    {"rot", "w,x,y,z", [](const OpenDevice&, const DeviceNow& s, Core&) { return toJson(quat(s.sample.q)); }},
    {"velocity", "[m/s]", [](const OpenDevice&, const DeviceNow& s, Core&) { return toJson(vec3(s.sample.v)); }},
    {"force", "sent to the device [N]",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return toJson(vec3(s.sample.force)); }},
    {"torque", "sent to the device [N m]",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return toJson(vec3(s.sample.torque)); }},
    {"by_source", "the force by owner [N]", getBySource},
    {"proxy", "[m]", [](const OpenDevice&, const DeviceNow& s, Core&) { return toJson(vec3(s.sample.proxy)); }},
    {"depth", "penetration [m]", [](const OpenDevice&, const DeviceNow& s, Core&) { return number(s.sample.depth_m); }},
    {"contact", "object in contact, empty for none",
     [](const OpenDevice&, const DeviceNow& s, Core& core) {
       return Json(core.scene().nameOf(s.sample.contact_object));
     }},
    {"buttons", "bit mask", [](const OpenDevice&, const DeviceNow& s, Core&) { return Json(s.sample.buttons); }},
    {"gripper", "[rad]", [](const OpenDevice&, const DeviceNow& s, Core&) { return number(s.sample.gripper_rad); }},
    {"armed", "forces reach it", [](const OpenDevice&, const DeviceNow& s, Core&) { return Json(s.armed); }},
    {"ramping", "the arming ramp is below one",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return Json((s.sample.flags & HD_SAMPLE_RAMPING) != 0); }},
    {"waiting", "armed, but the ramp waits until the force asked for is small",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return Json((s.sample.flags & HD_SAMPLE_WAITING) != 0); }},
    {"fault", "latched fault",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return Json(faultText(s.sample.fault)); }},
    {"lease", "who may arm it", getLease},
    {"radius", "of the ball about the device point [m]",
     [](const OpenDevice& d, const DeviceNow&, Core&) { return number(d.radius); }, setRadius},
    {"finger", "what touches is a fingertip: LAW[,arm=M][,radius=M][,stiffness=N m/rad][,damping=][,cue=][,uncoupled]",
     getFinger, setFinger},
    {"mount", "where it stands in the world: x,y,z[,deg,deg,deg|,w,x,y,z]; only while it is disarmed", getMount,
     setMount},
    {"scale", "metres of the world for one of the hand, or METRESm, the radius of the workspace there; as mount",
     getScale, setScale},
    {"clutch", "takes the hand off its point, which stands still: held or released, or a button's number", getClutch,
     setClutch},
    {"tool", "object in the hand: NAME[,kg[,N/m]][,weighs][,direct]", getTool, setTool},
    {"grip", "spring that opens the gripper where it is closed further than a width: N/rad,rad", getGrip, setGrip},
    {"limits", "in force", [](const OpenDevice& d, const DeviceNow&, Core&) { return toJson(d.limits); }},
    {"rate", "[Hz]", [](const OpenDevice&, const DeviceNow& s, Core&) { return number(s.rate_hz); }},
    {"counts", "cycles, missed, overruns, stale", getCounts},
    {"busy", "median share of the period spent in the cycle",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return number(s.busy); }},
    {"group", "devices of one group share a servo",
     [](const OpenDevice& d, const DeviceNow&, Core&) { return Json(d.link->name()); }},
    {"policy", "scheduling", [](const OpenDevice&, const DeviceNow& s, Core&) { return Json(s.policy); }},
    {"round_trip", "from a command sent to its answer, of a device with an I/O thread; else null [us]", getRoundTrip},
    {"temperature", "hottest motor [deg C], null where not sensed",
     [](const OpenDevice& d, const DeviceNow&, Core&) { return number(d.device().temperature()); }},
    {"battery", "charge [%], null where there is none or it has not told",
     [](const OpenDevice& d, const DeviceNow&, Core&) {
       const auto* const device = dynamic_cast<const HasBattery*>(&d.device());
       const int percent = device == nullptr ? -1 : device->batteryPercent();
       return percent < 0 ? Json(nullptr) : Json(percent);
     }},
    {"heat", "of the motors by the force sent; 1 is all they stand for ever, from 0.85 on the force is derated",
     [](const OpenDevice&, const DeviceNow& s, Core&) { return number(s.heat); }},
};

}  // namespace

std::span<const DeviceProperty> deviceProperties() { return kDeviceProperties; }

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json toJson(const Vec3& x) { return {number(x.x()), number(x.y()), number(x.z())}; }

Json toJson(const Quat& q) { return {number(q.w()), number(q.x()), number(q.y()), number(q.z())}; }

Json toJson(const Pose& pose) { return {{"pos", toJson(pose.p)}, {"rot", toJson(pose.q)}}; }

Json toJson(const hd_material& m) {
  return {{"stiffness", number(m.stiffness)},
          {"damping", number(m.damping)},
          {"friction_static", number(m.friction_static)},
          {"friction_dynamic", number(m.friction_dynamic)}};
}

Json toJson(const GuardLimits& l) {
  return {{"force", number(l.force)},
          {"torque", number(l.torque)},
          {"force_slew", number(l.force_slew)},
          {"torque_slew", number(l.torque_slew)},
          {"velocity", number(l.velocity)},
          {"power", number(l.power)},
          {"active_power", number(l.active_power)},
          {"gripper_force", number(l.gripper_force)}};
}

Json toJson(const MeshInfo& m) {
  return {{"id", m.id},         {"vertices", m.vertices},     {"triangles", m.triangles},
          {"bytes", m.bytes},   {"lower", toJson(m.lower)},   {"upper", toJson(m.upper)},
          {"closed", m.closed}, {"deformable", m.deformable}, {"notes", m.notes},
          {"uses", m.uses},     {"owner", m.owner.name},      {"voxel", m.voxel}};
}

Json toJson(const TextureInfo& t) {
  return {{"id", t.id},           {"kind", t.is_relief ? "relief" : "vibration"},
          {"width", t.width},     {"height", t.height},
          {"models", t.models},   {"rate_hz", number(t.rate_hz)},
          {"bytes", t.bytes},     {"uses", t.uses},
          {"owner", t.owner.name}};
}

}  // namespace hapticd
