// What a cycle tells the control thread: touches, buttons, faults, models that expired, orders refused.
#include <algorithm>

#include "rt/cycle/cycle.h"

namespace hapticd {
namespace {

ServoEvent eventAt(ServoEventKind kind, std::uint32_t device, const CycleInput& input) HD_RT {
  ServoEvent event;
  event.kind = kind;
  event.device = device;
  event.t_ns = input.now_ns;
  event.tick = input.tick;
  return event;
}

/** The object that a command is about; 0: none. */
std::uint32_t objectOf(const Command& command) HD_RT {
  switch (command.kind) {
    case CommandKind::kObjectPose:
    case CommandKind::kObjectMaterial:
    case CommandKind::kObjectFlags:
    case CommandKind::kObjectVertices:
    case CommandKind::kAddObject:
    case CommandKind::kRemoveObject:
    case CommandKind::kSetShape:
    case CommandKind::kSetSurface:
    case CommandKind::kSetBody:
    case CommandKind::kSetEffect:
      return command.as<ObjectRef>().object;  // Stands first in all of these.
    case CommandKind::kAttachTool:
      return command.as<AttachTool>().object;
    default:
      return 0;
  }
}

// A new kind of command does not compile until this switch says whether it names a device.
#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wswitch"
/** The device that an order is for; 0 as well where it is for none. */
std::uint32_t deviceOf(const Command& command) HD_RT {
  switch (command.kind) {
    case CommandKind::kArm:
    case CommandKind::kDisarm:
    case CommandKind::kStop:
    case CommandKind::kDeviceLimits:
    case CommandKind::kDeviceRadius:
    case CommandKind::kAttachTool:
    case CommandKind::kDetachTool:
    case CommandKind::kSetGrip:
    case CommandKind::kSetMount:
    case CommandKind::kSetFinger:
    case CommandKind::kSetClutch:
      return command.as<DeviceRef>().device;  // Stands first in all of these.
    case CommandKind::kNone:
    case CommandKind::kObjectPose:
    case CommandKind::kObjectMaterial:
    case CommandKind::kObjectFlags:
    case CommandKind::kObjectVertices:
    case CommandKind::kLocalModel:
    case CommandKind::kForceField:
    case CommandKind::kClearModel:
    case CommandKind::kClientForce:
    case CommandKind::kIntent:
    case CommandKind::kLimits:
    case CommandKind::kAddObject:
    case CommandKind::kRemoveObject:
    case CommandKind::kSetShape:
    case CommandKind::kAddSession:
    case CommandKind::kLoseSession:
    case CommandKind::kReviveSession:
    case CommandKind::kFreeSession:
    case CommandKind::kSetSurface:
    case CommandKind::kToolContacts:  // May also be for a body.
    case CommandKind::kSetBody:
    case CommandKind::kSetGravity:
    case CommandKind::kSetEffect:
      return 0;
  }
  return 0;
}
#pragma GCC diagnostic pop

}  // namespace

void Cycle::refuse(const Command& command, ErrorCode code, const CycleInput& input, CycleOutput& output) HD_RT {
  ServoEvent event = eventAt(ServoEventKind::kCommandRefused, deviceOf(command), input);
  event.session = command.session;
  event.value = static_cast<std::uint32_t>(code);
  event.object = objectOf(command);
  event.order = static_cast<std::uint32_t>(command.kind);
  output.events.add(event);
}

void Cycle::noteExpiredModels(const CycleInput& input, CycleOutput& output) HD_RT {
  for (std::uint32_t s = 0; s < kMaxSessions; ++s) {
    if (sessions_[s].life() == SessionShare::Life::kFree) continue;
    for (std::uint32_t m = 0; m < HD_MODEL_SLOTS; ++m) {
      auto& model = sessions_[s].model(m);
      if (!model.takeExpired()) continue;
      ServoEvent event = eventAt(ServoEventKind::kModelExpired, model.device(), input);
      event.session = s;
      event.value = m;
      output.events.add(event);
    }
  }
}

/**
 * Of each object a touch and its end are told in turns, whatever ends one: a tool taken up or let go, a reading not to
 * be used.
 */
void Cycle::raiseTouches(std::uint32_t d, const CycleInput& input, CycleOutput& output) HD_RT {
  auto& touched = devices_[d].touched;
  const SurfaceContact& contact = output.device[d].contact;
  const auto raise = [&](ServoEventKind kind, std::uint32_t object, const Vec3& force, const Vec3& point) HD_RT {
    ServoEvent event = eventAt(kind, d, input);
    event.object = object;
    event.force = devices_[d].clutch.weight() * force.norm();
    store(point, event.point);
    output.events.add(event);
  };
  for (std::uint32_t& id : touched) {
    bool still = contact.parts == 0 && id == contact.object;
    for (std::uint32_t i = 0; i < contact.parts; ++i) still = still || id == contact.part[i].object;
    if (id == 0 || (still && !contact.touch)) continue;
    raise(ServoEventKind::kUntouch, id, contact.force, contact.point);
    id = 0;
  }
  const auto touch = [&](std::uint32_t id, const Vec3& force, const Vec3& point) HD_RT {
    if (id == 0 || std::ranges::find(touched, id) != touched.end()) return;
    if (const auto free = std::ranges::find(touched, 0u); free != touched.end()) *free = id;
    raise(ServoEventKind::kTouch, id, force, point);
  };
  if (contact.parts == 0) touch(contact.object, contact.force, contact.point);
  for (std::uint32_t i = 0; i < contact.parts; ++i) {
    const ContactPart& part = contact.part[i];
    touch(part.object, part.force, part.point);
  }
}

void Cycle::tellOn(const Cycle& former) noexcept {
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    DeviceState& device = devices_[d];
    const DeviceState& before = former.devices_[d];
    device.touched = before.touched;
    device.buttons = before.buttons;
    device.moved = device.moved || before.moved;
    device.last_fault = before.last_fault;
    device.last_armed = before.last_armed;
    device.last_warm = before.last_warm;
  }
}

void Cycle::raiseEvents(std::uint32_t d, const CycleInput& input, CycleOutput& output) HD_RT {
  DeviceState& device = devices_[d];
  DeviceOutput& out = output.device[d];
  if (d == 0 && input.missed != 0) {  // The first stands for the group.
    ServoEvent event = eventAt(ServoEventKind::kOverrun, d, input);
    event.value = input.missed;
    output.events.add(event);
  }
  raiseTouches(d, input, output);

  if (device.moved && output.events.count < EventBatch::kCapacity) {
    ServoEvent event = eventAt(ServoEventKind::kMoved, d, input);
    store(device.mount.pose().p, event.point);
    output.events.add(event);
    device.moved = false;
  }
  const std::uint32_t buttons = input.device[d].buttons;
  if (buttons != device.buttons) {
    ServoEvent event = eventAt(ServoEventKind::kButton, d, input);
    event.value = buttons;
    output.events.add(event);
    device.buttons = buttons;
  }
  if (out.guard.fault != device.last_fault) {
    if (out.guard.fault != HD_FAULT_NONE) {
      ServoEvent event = eventAt(ServoEventKind::kFault, d, input);
      event.value = out.guard.fault;
      output.events.add(event);
    }
    device.last_fault = out.guard.fault;
  }
  if (out.guard.warm != device.last_warm) {
    ServoEvent event = eventAt(ServoEventKind::kWarm, d, input);
    event.value = out.guard.warm ? 1 : 0;
    output.events.add(event);
    device.last_warm = out.guard.warm;
  }
  const bool armed = device.guard.armed();
  if (armed != device.last_armed) {
    output.events.add(eventAt(armed ? ServoEventKind::kArmed : ServoEventKind::kDisarmed, d, input));
    device.last_armed = armed;
  }
}

}  // namespace hapticd
