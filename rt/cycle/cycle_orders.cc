// Which commands a tick takes, and what each changes.
#include <algorithm>

#include "rt/cycle/cycle.h"
#include "rt/guard/damping_left.h"

namespace hapticd {

void Cycle::applyCommands(const CycleInput& input, CycleOutput& output) HD_RT {
  periods_ = 1.0 + input.missed;
  if (last_tick_ != 0 && input.tick > last_tick_ + input.missed + 1)  // The servo stood for a while.
    periods_ = static_cast<double>(input.tick - last_tick_);
  last_tick_ = input.tick;
  scene_.expect(period() * periods_, input.tick);
  output.events.clear();
  output.applied_commands = 0;
  for (std::uint32_t d = 0; d < config_.device_count; ++d) output.device[d].has_intent = false;

  // Those whose tick has come, in the order they arrived; the rest close up.
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < pending_count_; ++i) {
    if (pending_[i].kind == CommandKind::kNone) continue;  // its sender is gone
    if (pending_[i].at_tick <= input.tick) {
      apply(pending_[i], input, output);
    } else {
      if (kept != i) pending_[kept] = pending_[i];
      ++kept;
    }
  }
  pending_count_ = kept;

  for (std::uint32_t i = 0; i < input.command_count; ++i) {
    const Command& command = input.command[i];
    if (command.at_tick <= input.tick) {
      apply(command, input, output);
    } else if (pending_count_ < kMaxPending) {
      pending_[pending_count_++] = command;
    } else {
      refuse(command, ErrorCode::kQuotaExceeded, input, output);
    }
  }
}

ErrorCode Cycle::applyToSession(const Command& command, const CycleInput& input) HD_RT {
  if (command.session >= kMaxSessions) return ErrorCode::kInvalidArgument;
  SessionShare& session = sessions_[command.session];
  if (session.life() != SessionShare::Life::kAlive) return ErrorCode::kDisconnected;
  return session.apply(command, input.now_ns, scene_);
}

ErrorCode Cycle::applySessionOrder(const Command& command, const CycleInput& input) HD_RT {
  const std::uint32_t slot = command.as<SessionRef>().slot;
  if (slot >= kMaxSessions) return ErrorCode::kInvalidArgument;
  SessionShare& session = sessions_[slot];
  switch (command.kind) {
    case CommandKind::kAddSession:
      session.start(command.as<SessionRef>().id);
      break;
    case CommandKind::kLoseSession:
      session.lose(input.now_ns, config_.loss_fade_ns);
      scene_.halt(slot);
      break;
    case CommandKind::kReviveSession:
      session.revive();
      break;
    default:
      scene_.halt(slot);
      session.free();
      // Commands that this session sent for later ticks must not act for the slot's next owner.
      for (std::uint32_t i = 0; i < pending_count_; ++i) {
        if (pending_[i].session == slot) pending_[i].kind = CommandKind::kNone;
      }
      break;
  }
  return ErrorCode::kOk;
}

ErrorCode Cycle::applyDeviceOrder(const Command& command) HD_RT {
  const std::uint32_t device = command.as<DeviceRef>().device;
  if (command.kind == CommandKind::kToolContacts && device >= kMaxDevices) {
    return bodies_.take(command.as<ToolContacts>());
  }
  if (device >= config_.device_count) return ErrorCode::kInvalidArgument;
  Guard& guard = devices_[device].guard;
  switch (command.kind) {
    case CommandKind::kArm:
      return guard.arm();
    case CommandKind::kDisarm:
      guard.disarm();
      return ErrorCode::kOk;
    case CommandKind::kStop: {
      const std::uint32_t cause = command.as<StopOrder>().cause;
      guard.latch(cause == HD_FAULT_NONE || cause >= HD_FAULT_COUNT ? std::uint32_t{HD_FAULT_STOP_LINE} : cause);
      return ErrorCode::kOk;
    }
    case CommandKind::kDeviceRadius: {
      const double radius = command.as<DeviceRadius>().radius;
      if (!(radius >= 0 && radius <= ProxyRenderer::kMaxRadius)) return ErrorCode::kInvalidArgument;
      devices_[device].proxy.setRadius(radius);
      return ErrorCode::kOk;
    }
    case CommandKind::kSetMount:
      return applyMount(command.as<SetMount>());
    case CommandKind::kSetFinger: {
      const auto& finger = command.as<SetFinger>();
      if (!SoftFinger::valid(finger)) return ErrorCode::kInvalidArgument;
      devices_[device].finger.set(finger);
      devices_[device].proxy.bear({});
      return ErrorCode::kOk;
    }
    case CommandKind::kSetClutch:
      if (!Clutch::valid(command.as<SetClutch>())) return ErrorCode::kInvalidArgument;
      devices_[device].clutch.set(command.as<SetClutch>());
      return ErrorCode::kOk;
    case CommandKind::kAttachTool:
    case CommandKind::kDetachTool:
      return applyToHand(devices_[device].tool, command);
    case CommandKind::kToolContacts:
      return devices_[device].tool.take(command.as<ToolContacts>());
    case CommandKind::kSetGrip: {
      const auto& grip = command.as<SetGrip>();
      if (!(grip.stiffness >= 0 && grip.stiffness < 1e6 && grip.width >= 0 && grip.width < 10))
        return ErrorCode::kInvalidArgument;
      devices_[device].grip = grip;
      return ErrorCode::kOk;
    }
    default: {
      const auto& wanted = command.as<DeviceLimits>();
      const GuardLimits limits = limitsOf(wanted);
      return guard.setLimits(wanted.only_lowers != 0 ? lower(limits, guard.limits()) : limits);
    }
  }
}

ErrorCode Cycle::applyToHand(HeldTool& tool, const Command& command) HD_RT {
  const std::uint32_t former = tool.order().object;
  if (command.kind == CommandKind::kDetachTool) {
    tool.detach();
  } else if (const ErrorCode code = tool.attach(command.as<AttachTool>(), scene_); code != ErrorCode::kOk) {
    return code;
  }
  if (former != tool.order().object && !bodies_.isBody(former)) stand(former);  // A body flies on.
  return ErrorCode::kOk;
}

/** In any servo. Where it is only its hand says: those who touch it would meet a client's word for a tick. */
bool Cycle::isHeld(std::uint32_t object) const HD_RT {
  const SceneObject* const it = scene_.find(object);
  if (it != nullptr && (it->flags & kObjectInHand) != 0) return true;
  const auto first = devices_.begin(), last = first + config_.device_count;
  return std::any_of(first, last,
                     [=](const DeviceState& d) { return d.tool.held() && d.tool.order().object == object; });
}

/** What no hand moves on stays where it is; with the hand's last velocity it would go on for ever. */
void Cycle::stand(std::uint32_t object) HD_RT {
  const SceneObject* const it = scene_.find(object);
  if (it == nullptr || isZero(it->V_PO)) return;
  (void)scene_.apply(makeCommand(CommandKind::kObjectPose, poseMessage(object, it->X_PO), kCycleSession));
}

/** The hand is elsewhere at once: only where no force can jump with it. What touched begins anew. */
ErrorCode Cycle::applyMount(const SetMount& order) HD_RT {
  DeviceState& device = devices_[order.device];
  if (!Mount::valid(order)) return ErrorCode::kInvalidArgument;
  if (device.guard.armed()) return ErrorCode::kWouldBlock;
  // While the clutch is held only the scale changes here; the place follows when it is let go.
  if (order.keeps_place != 0) {
    device.mount = Mount(device.mount.pose(), order.scale);
  } else {
    device.mount = Mount(order);
    device.clutch.thaw();
  }
  scaleToWorld(device);
  device.moved = true;
  device.started = false;
  device.tool.forget();
  return ErrorCode::kOk;
}

/** Of what is rendered in the world; estimator and guard are the device's. */
void Cycle::scaleToWorld(DeviceState& device) HD_RT {
  const double step = device.mount.scale() * device.read_resolution;
  device.resolution = step;
  device.proxy.setResolution(step);
  device.proxy.setMaxDamping(mostDamping(device.max_damping / device.mount.scale()));
  device.effects.setResolution(step, VelocityEstimator::noiseAtRest(step, period()));
}

ErrorCode Cycle::applyToBodies(const Command& command) HD_RT {
  if (command.kind == CommandKind::kSetBody) return bodies_.set(command.as<SetBody>(), scene_);
  if (command.kind == CommandKind::kSetGravity) return bodies_.setGravity(command.as<SetGravity>());
  if (command.session < kMaxSessions && isHeld(command.as<hd_object_pose>().object)) return ErrorCode::kOk;
  const ErrorCode code = scene_.apply(command);
  if (code == ErrorCode::kOk) {
    bodies_.moved(command.as<hd_object_pose>(), command.session == kControlSession, scene_.tick());
    // Of what it had sent ahead the place holds still, but nobody is there who would end the motion.
    if (command.session < kMaxSessions && sessions_[command.session].life() == SessionShare::Life::kLost)
      stand(command.as<hd_object_pose>().object);
  }
  return code;
}

void Cycle::apply(const Command& command, const CycleInput& input, CycleOutput& output) HD_RT {
  ErrorCode code = ErrorCode::kOk;
  switch (command.kind) {
    case CommandKind::kNone:
      return;
    case CommandKind::kObjectPose:
    case CommandKind::kSetBody:
    case CommandKind::kSetGravity:
      code = applyToBodies(command);
      break;
    case CommandKind::kObjectMaterial:
    case CommandKind::kObjectFlags:
    case CommandKind::kObjectVertices:
    case CommandKind::kAddObject:
    case CommandKind::kRemoveObject:
    case CommandKind::kSetShape:
    case CommandKind::kSetSurface:
    case CommandKind::kSetEffect:
      code = scene_.apply(command);
      break;
    case CommandKind::kLocalModel:
    case CommandKind::kForceField:
    case CommandKind::kClearModel:
    case CommandKind::kClientForce:
    case CommandKind::kLimits:
      code = applyToSession(command, input);
      break;
    case CommandKind::kIntent: {
      const auto& wish = command.as<hd_intent>();
      if (wish.device >= config_.device_count) {
        code = ErrorCode::kInvalidArgument;
        break;
      }
      DeviceOutput& out = output.device[wish.device];
      const Pose hand = devices_[wish.device].mount.toDevice(Pose{vec3(wish.p), quat(wish.q)});
      out.intent = {hand.p, hand.q, wish.gripper_rad};
      out.has_intent = true;
      break;
    }
    case CommandKind::kAddSession:
    case CommandKind::kLoseSession:
    case CommandKind::kReviveSession:
    case CommandKind::kFreeSession:
      code = applySessionOrder(command, input);
      break;
    case CommandKind::kArm:
    case CommandKind::kDisarm:
    case CommandKind::kStop:
    case CommandKind::kDeviceLimits:
    case CommandKind::kDeviceRadius:
    case CommandKind::kAttachTool:
    case CommandKind::kDetachTool:
    case CommandKind::kToolContacts:
    case CommandKind::kSetGrip:
    case CommandKind::kSetMount:
    case CommandKind::kSetFinger:
    case CommandKind::kSetClutch:
      code = applyDeviceOrder(command);
      break;
  }
  if (code != ErrorCode::kOk) {
    refuse(command, code, input, output);
  } else {
    ++output.applied_commands;
  }
  if (command.session < kMaxSessions && command.channel == 0)
    sessions_[command.session].noteApplied(command.seq, input.tick);
}

}  // namespace hapticd
