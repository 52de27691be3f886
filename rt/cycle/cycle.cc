#include "rt/cycle/cycle.h"

#include <algorithm>

#include "rt/guard/damping_left.h"

namespace hapticd {

Cycle::Cycle(const CycleConfig& config, const MeshTable& meshes) noexcept
    : config_(config),
      scene_(meshes),
      devices_{DeviceState(config.guard[0], 0), DeviceState(config.guard[1], 1), DeviceState(config.guard[2], 2),
               DeviceState(config.guard[3], 3)} {
  static_assert(kMaxDevices == 4, "one DeviceState each above");
  for (DeviceState& device : devices_) scaleToWorld(device);
}

void Cycle::step(const CycleInput& input, CycleOutput& output) HD_RT {
  applyCommands(input, output);
  render(input, output);
  guard(input, output);
}

void Cycle::render(const CycleInput& input, CycleOutput& output) HD_RT {
  const double dt = period();
  scene_.advance(dt * periods_);
  moveTools(input, output);
  // Points push bodies before these are stepped; with them tools are, and then feel it.
  const auto renderThose = [&](bool with_tools) HD_RT {
    for (std::uint32_t d = 0; d < config_.device_count; ++d) {
      if (devices_[d].tool.held() == with_tools) renderDevice(d, input, output.device[d]);
    }
  };
  renderThose(false);
  bodies_.step(scene_, dt);
  renderThose(true);
  noteExpiredModels(input, output);
}

std::uint32_t Cycle::heldObjects(std::array<std::uint32_t, kMaxDevices>& held) const HD_RT {
  std::uint32_t n = 0;
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    if (devices_[d].tool.held()) held[n++] = devices_[d].tool.order().object;
  }
  return n;
}

/** Where the hand is in the world; how fast, DeviceOutput::velocity says. */
const DeviceSample& Cycle::place(std::uint32_t d, const CycleInput& input) HD_RT {
  DeviceState& device = devices_[d];
  const DeviceSample& read = input.device[d];
  if (usable(read)) moveClutch(d, input);
  if (asRead(device)) return read;
  const Pose hand = device.mount.toWorld(Pose{read.p, read.q});
  device.placed = read;
  device.placed.p = hand.p;
  device.placed.q = hand.q;
  if (device.clutch.frozen()) device.placed.p = device.clutch.anchor();
  return device.placed;
}

/** Estimates the hands' velocities and moves what they hold; bodies wait for what pushes them. */
void Cycle::moveTools(const CycleInput& input, CycleOutput& output) HD_RT {
  const double dt = period();
  std::array<std::uint32_t, kMaxDevices> held;
  bodies_.begin(scene_, dt, {held.data(), heldObjects(held)});
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    DeviceState& device = devices_[d];
    const DeviceSample& sample = place(d, input);
    Twist& velocity = output.device[d].velocity;
    output.device[d].pose = {sample.p, sample.q};
    if (!usable(input.device[d]) || !usable(sample)) {  // The guard latches a fault; nothing may compute with it.
      device.started = false;
      device.velocity.reset();
      device.tool.forget();
      stand(device.tool.order().object);
      velocity = device.velocity_D = Twist{};
      continue;
    }
    device.velocity_D = device.velocity.update(input.device[d]);
    velocity = device.mount.toWorld(device.velocity_D);
    if (device.clutch.frozen()) velocity.v.setZero();
    if (device.tool.held()) device.tool.begin(scene_, sample, velocity, dt, bodies_);
  }
}

void Cycle::renderDevice(std::uint32_t d, const CycleInput& input, DeviceOutput& out) HD_RT {
  DeviceState& device = devices_[d];
  const DeviceSample& sample = asRead(device) ? input.device[d] : device.placed;
  auto& source = sources_[d];
  Energy& energy = energy_[d];
  source.fill(Wrench{});
  energy = Energy{};
  out.contact = SurfaceContact{};
  if (!usable(input.device[d]) || !usable(sample)) return;
  if (!device.started) {
    device.proxy.reset(sample.p);
    device.shading.reset();
    device.finger.reset();
    device.effects.reset();
    device.object_effects.reset();
    device.lending = {.hand = sample.p};
    device.started = true;
  }
  energy.gripper = device.grip.stiffness * std::max(0.0, device.grip.width - sample.gripper_rad);
  if (device.tool.held()) {
    renderTool(d, sample, out);
  } else {
    if (device.finger.soft()) device.proxy.bear(device.finger.turn(scene_, sample.q));
    device.proxy.step(scene_, sample.p, out.velocity.v, period(), out.contact);
    device.shading.step(scene_, device.proxy.holding(), out.velocity.v, out.contact);
    FingerForces pad = touchSoftly(d, out);
    source[HD_SOURCE_SURFACE].force = out.contact.force;
    const SurfaceForces added =
        device.effects.step(scene_, out.contact, device.proxy.holding(), sample.p, out.velocity.v);
    // A relief that takes away part of the normal force takes the same part of the pad's friction.
    if (const double presses = out.contact.force.dot(out.contact.normal); presses > 0) {
      const double left = std::clamp(1 + added.relief.dot(out.contact.normal) / presses, 0.0, 1.0);
      pad.moment *= left;
      pad.cue *= left;
    }
    if (device.finger.order().shows_moment != 0) source[HD_SOURCE_SURFACE].torque = pad.moment * out.contact.normal;
    source[HD_SOURCE_TEXTURE].force = added.texture() + pad.cue;
    source[HD_SOURCE_TRANSIENT].force = added.transient;
    energy.relief = added.relief;
    energy.carried = out.contact.force.cwiseProduct(out.contact.velocity) + out.contact.apart + added.carried;
    const double put_in = changed(device, out.contact, added.stored);
    device.lending.energy += put_in;
    energy.carried += byAxis(put_in / period(), out.contact.force + added.relief);
    if (out.contact.object != 0) {
      energy.stored = added.stored;
      energy.damping = std::max(out.contact.damping_gain, pad.damping);
      pushBodies(device, sample.p, out.contact, out.contact.force + added.texture(), pad.moment * out.contact.normal,
                 device.clutch.weight());
    } else {
      device.lending.begin(0, Vec3::Zero());
    }
    device.lending.hand = sample.p;
  }

  const double can = device.max_damping / device.mount.scale();  // In the world.
  ToolPoint tool{sample.p, out.velocity.v, d, device.resolution};
  for (SessionShare& session : sessions_) {
    if (session.life() == SessionShare::Life::kFree) continue;
    tool.most_damping = mostDamping(can, energy.damping);
    const SessionShare::Share share = session.evaluate(tool, input.now_ns, scene_);
    source[HD_SOURCE_LOCAL_MODEL].force += share.local_model;
    source[HD_SOURCE_CLIENT].force += share.client_force;
    source[HD_SOURCE_CLIENT].torque += share.client_torque;
    energy.local_active += share.local_active;
    energy.carried += share.carried;
    energy.stored += share.stored;
    energy.damping += share.damping;
  }
  device.object_effects.setMaxDamping(dampingLeft(can, energy.damping));
  source[HD_SOURCE_EFFECT].force = device.object_effects.step(scene_, sample.p, out.velocity.v, period(), input.now_ns);
  energy.damping += device.object_effects.damping();
  if (!device.mount.identity()) bringToDevice(d, out);
  weighClutch(d, out.contact, sample.p);
  source[HD_SOURCE_GRAVITY].force = device.mount.upright() * input.device[d].gravity;
}

/** What was rendered in the world, for the guard. The touched surface's power is known by its parts. */
void Cycle::bringToDevice(std::uint32_t d, const DeviceOutput& out) HD_RT {
  const Mount& mount = devices_[d].mount;
  for (Wrench& source : sources_[d]) source = mount.toDevice(source);
  Energy& energy = energy_[d];
  energy.local_active = mount.toDevice(energy.local_active);
  energy.relief = mount.toDevice(energy.relief);
  const Vec3 &f = out.contact.force, &v = out.contact.velocity;
  const double s = mount.scale();
  energy.carried =
      mount.powerToDevice(energy.carried - f.cwiseProduct(v)) + mount.toDevice(f).cwiseProduct(mount.toDevice(v)) / s;
  energy.stored /= s;
  energy.damping *= s;
}

void Cycle::renderTool(std::uint32_t d, const DeviceSample& sample, DeviceOutput& out) HD_RT {
  // The tool touches the scene instead of the device's own point, which starts afresh when the tool is let go.
  DeviceState& device = devices_[d];
  device.proxy.reset(sample.p);
  device.shading.reset();
  device.finger.reset();
  device.effects.reset();
  device.pressed = {};
  device.lending = {.hand = sample.p};
  HeldToolOutput held;
  device.tool.finish(scene_, out.velocity, period(), held);
  sources_[d][HD_SOURCE_SURFACE] = held.wrench;
  energy_[d].carried = held.carried;
  energy_[d].stored = held.stored;
  SurfaceContact& contact = out.contact;
  contact.force = held.wrench.force;
  contact.proxy = device.tool.tool().body().pose().p;
  contact.point = held.touched != 0 ? held.point : contact.proxy;
  contact.normal = contact.smooth = held.normal;
  contact.depth = held.touched != 0 ? (contact.proxy - sample.p).norm() : 0.0;
  contact.object = held.touched;
  contact.touch = held.touch;
}

bool Cycle::ask(CollideRequest& request) const HD_RT {
  std::array<std::uint32_t, kMaxDevices> held;
  request.tick = scene_.tick();
  bool any = bodies_.ask(scene_, {held.data(), heldObjects(held)}, request);
  for (std::uint32_t d = 0; d < kMaxDevices; ++d) {
    request.held[d].object = 0;
    if (!devices_[d].tool.held()) continue;
    devices_[d].tool.ask(scene_, bodies_, request.held[d]);
    any = true;
  }
  return any;
}

void Cycle::guard(const CycleInput& input, CycleOutput& output) HD_RT {
  for (std::uint32_t d = 0; d < config_.device_count; ++d) {
    DeviceState& device = devices_[d];
    DeviceOutput& out = output.device[d];
    GuardInput in;
    in.now_ns = input.now_ns;
    in.dt = period();
    in.sample = &input.device[d];
    in.velocity = device.velocity_D;
    in.source = sources_[d];
    in.stop_line = input.stop_line;
    in.deadman_open = input.deadman_open;
    in.missed = input.missed;
    in.local_active = energy_[d].local_active;
    in.relief = energy_[d].relief;
    in.carried = energy_[d].carried;
    in.stored = energy_[d].stored;
    in.damping = energy_[d].damping;
    in.gripper_force = energy_[d].gripper;
    device.guard.step(in, out.guard);
    out.command = out.guard.command;
    raiseEvents(d, input, output);
  }
}

}  // namespace hapticd
