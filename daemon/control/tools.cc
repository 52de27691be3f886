// Which object is the tool in a device's hand, and what its gripper closes on.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "daemon/control/core.h"
#include "daemon/log/log.h"
#include "daemon/scene/body.h"
#include "rt/body/coupling.h"
#include "rt/collide/scene_contacts.h"

namespace hapticd {
namespace {

constexpr double kLightest = 0.01, kHeaviest = 10;  ///< [kg]
constexpr double kStiffestGrip = 1000;              ///< [N/rad]

void append(std::string& note, const std::string& why) {
  if (!why.empty()) note += (note.empty() ? "" : "; ") + why;
}

/** What the hand must not expect of a tool of that shape; empty: nothing. */
std::string toolNote(const std::string& name, const ShapeSpec& shape, const MeshStore& meshes, bool shows_torque) {
  std::string note = shows_torque ? "" : "the device cannot show torque: the hand feels the force alone";
  append(note, withoutField(name, shape, meshes, SceneContacts::kPatches));
  return note;
}

/** Empty: the coupling is as stiff as it was wished, or nothing was. */
std::string softerNote(double stiffness, double wished) {
  constexpr double kRounding = 1e-9;
  if (stiffness >= wished * (1 - kRounding)) return {};
  return fmt::format("the device bears {:.4g} N/m, not the {:g} asked for", stiffness, wished);
}

}  // namespace

Result<void> Core::mayChange(const OpenDevice& device, const Client& by) {
  const Session* holder = device.lease == 0 ? nullptr : sessions_.find(device.lease);
  if (!by.administration && holder != nullptr && holder->client.uid != by.uid) {
    return Error{ErrorCode::kLeaseHeld, device.name,
                 fmt::format("'{}' (pid {}) holds the lease", log::printable(holder->client.name), holder->client.pid),
                 "wait until it is released"};
  }
  if (!device.link->accepting()) {
    return Error{ErrorCode::kTimeout, device.name, "too many edits wait for the servo",
                 "edit less often; if it stays so, see hapticctl status"};
  }
  return {};
}

Result<void> Core::attachTool(OpenDevice& device, const ToolWish& wish, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  const auto refuse = [&](std::string what, std::string remedy) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/tool", std::move(what), std::move(remedy)};
  };
  auto object = scene_.find(wish.object);
  if (!object) return object.error();
  if (auto r = checkMovable(object->spec, meshes_, device.name + "/tool"); !r) return r;
  if (!(wish.mass >= kLightest && wish.mass <= kHeaviest)) {
    return refuse(fmt::format("a tool weighs {:g} to {:g} kg", kLightest, kHeaviest), "for example 0.1");
  }
  if (!(wish.stiffness >= 0 && std::isfinite(wish.stiffness))) {
    return refuse("the coupling's stiffness is a number of N/m", "0 chooses the stiffest that is passive");
  }
  for (const auto& other : devices_.devices()) {
    if (other.get() != &device && other->tool.object == wish.object && other->tool.id == object->id) {
      return Error{ErrorCode::kAlreadyExists, device.name + "/tool",
                   fmt::format("'{}' is in the hand of {}", wish.object, other->name), "detach it there first"};
    }
  }

  const HeldObject former = device.tool;
  hold(device, wish, *object);
  if (former.id != object->id) putAway(device.name, former);
  const HeldObject& tool = device.tool;
  log::info("{}: holds '{}', {:g} kg at {:g} N/m{}{}", device.name, log::printable(tool.object), tool.mass,
            tool.stiffness, tool.note.empty() ? "" : "; ", log::printable(tool.note));
  tellTool(device.name, tool.object, tool.note.empty() ? "tool" : "tool; " + tool.note);
  return {};
}

/** Inertia and coupling are those of its shape as it now is. */
void Core::hold(OpenDevice& device, const ToolWish& wish, const ObjectNow& object) {
  const ShapeSpec& shape = object.spec.shape;
  const MassProperties mass = massOf(shape, meshes_, wish.mass);
  const DeviceInfo& info = device.info();
  const double dt = static_cast<double>(device.link->group().options().cycle.period_ns) * 1e-9;
  // Gains are chosen in the device's own scale, for the mass as felt there, then converted to the world's.
  const double s = device.mount.scale();
  const CouplingNeeds needs{s * wish.mass, mass.inertia_O.trace() / 3 / s, dt, s * wish.stiffness};
  CouplingGains gains = chooseGains(info, needs);
  for (double* x : {&gains.outer, &gains.stiffness, &gains.damping}) *x /= s;
  for (double* x : {&gains.angular_outer, &gains.angular_stiffness, &gains.angular_damping}) *x *= s;
  const bool shows_torque = info.actuated_rotation && info.max_torque > 0;
  AttachTool order{};
  order.device = device.index;
  order.object = object.id;
  order.shows_torque = shows_torque ? 1 : 0;
  order.flags = (wish.weighs ? kToolWeighs : 0u) | (wish.direct ? kToolDirect : 0u);
  order.mass = wish.mass;
  store(mass.com_O, order.com);
  storeInertia(mass.inertia_O, order.inertia);
  order.outer = gains.outer;
  order.stiffness = gains.stiffness;
  order.damping = gains.damping;
  order.angular_outer = gains.angular_outer;
  order.angular_stiffness = gains.angular_stiffness;
  order.angular_damping = gains.angular_damping;
  (void)device.link->post(makeCommand(CommandKind::kAttachTool, order));
  scene_.setInHand(object.id, true);
  device.tool = {wish.object,
                 object.id,
                 wish.mass,
                 gains.outer * gains.stiffness / (gains.outer + gains.stiffness),
                 wish.stiffness,
                 shows_torque,
                 wish.weighs,
                 wish.direct,
                 toolNote(wish.object, shape, meshes_, shows_torque)};
  append(device.tool.note, softerNote(device.tool.stiffness, wish.stiffness));
}

/** What is in its hand, for what has changed about either. */
void Core::holdAnew(OpenDevice& device) {
  const HeldObject& tool = device.tool;
  const ToolWish as_before{tool.object, tool.mass, tool.wished_stiffness, tool.weighs, tool.direct};
  const auto now = scene_.find(tool.object);
  if (now && now->id == tool.id) hold(device, as_before, *now);
}

void Core::tellTool(const std::string& device, const std::string& object, const std::string& what) {
  Event event;
  event.kind = EventKind::kObjectChanged;
  event.t_ns = clock_.now();
  event.device = device;
  event.object = object;
  event.text = what;
  events_.publish(event);
}

void Core::putAway(const std::string& device, const HeldObject& held) {
  scene_.setInHand(held.id, false);
  const bool there = !held.object.empty() && scene_.nameOf(held.id) == held.object;  // Else it went with its object.
  if (there) tellTool(device, held.object, "tool detached");
}

Result<void> Core::setShape(std::string_view name, const ShapeSpec& shape) {
  const auto object = scene_.find(name);
  OpenDevice* holder = nullptr;
  const bool there = shape.kind != ShapeKind::kMesh || meshes_.find(shape.mesh) != nullptr;  // Else refused below.
  for (const auto& device : devices_.devices()) {
    if (!object || !there || device->tool.object != name || device->tool.id != object->id) continue;
    holder = device.get();
    ObjectSpec held = object->spec;
    held.shape = shape;
    if (auto r = checkMovable(held, meshes_, "shape"); !r) {
      return Error{r.error().code, r.error().where,
                   r.error().what + fmt::format(", and in the hand of {}", device->name),
                   "another shape, or detach it there first"};
    }
  }
  auto set = scene_.setShape(name, shape);
  if (!set || holder == nullptr) return set;
  holdAnew(*holder);
  return set;
}

Result<void> Core::notInHand(std::string_view name, const char* where) {
  for (const auto& device : devices_.devices()) {
    if (device->tool.object != name) continue;
    if (const auto object = scene_.find(name); !object || object->id != device->tool.id) continue;
    return Error{ErrorCode::kWouldBlock, where,
                 fmt::format("'{}' is in the hand of {}, and where that is", name, device->name),
                 "detach it there first"};
  }
  return {};
}

Result<void> Core::setPose(std::string_view name, const Pose& X_PO) {
  if (auto r = notInHand(name, "pose"); !r) return r;
  return scene_.setPose(name, X_PO);
}

Result<void> Core::setVelocity(std::string_view name, const Twist& V_PO) {
  if (auto r = notInHand(name, "velocity"); !r) return r;
  return scene_.setVelocity(name, V_PO);
}

Result<void> Core::detachTool(OpenDevice& device, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  const HeldObject held = std::exchange(device.tool, {});
  (void)device.link->post(makeCommand(CommandKind::kDetachTool, DeviceRef{device.index}));
  putAway(device.name, held);
  return {};
}

Result<void> Core::setGrip(OpenDevice& device, double stiffness, double width, const Client& by) {
  if (auto r = mayChange(device, by); !r) return r;
  const auto refuse = [&](std::string what, std::string remedy) {
    return Error{ErrorCode::kInvalidArgument, device.name + "/grip", std::move(what), std::move(remedy)};
  };
  const DeviceInfo& info = device.info();
  if (stiffness > 0 && !(info.sensed_gripper && info.actuated_gripper)) {
    return Error{ErrorCode::kUnsupported, device.name + "/grip", "the device has no gripper that can push",
                 "see its abilities: hapticctl info"};
  }
  if (!(stiffness >= 0 && stiffness <= kStiffestGrip)) {
    return refuse(fmt::format("the stiffness is not between 0 and {:g} N/rad", kStiffestGrip),
                  "0 lets it close freely");
  }
  if (!(width >= 0 && width <= std::max(info.gripper_max_angle, 0.0))) {
    return refuse(fmt::format("the width is not between 0 and {:g} rad", info.gripper_max_angle),
                  "it is the angle at which the jaws meet what they hold");
  }
  device.grip = {stiffness, width};
  (void)device.link->post(makeCommand(CommandKind::kSetGrip, SetGrip{device.index, 0, stiffness, width}));
  return {};
}

}  // namespace hapticd
