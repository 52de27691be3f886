#include "rt/cycle/cycle_log.h"

#include <algorithm>

namespace hapticd {
namespace {

void note(const DeviceSample& sample, const DeviceCommand& command, LoggedDevice& out) HD_RT {
  out.t_ns = sample.t_ns;
  store(sample.p, out.p);
  store(sample.q, out.q);
  store(sample.v, out.v);
  store(sample.w, out.w);
  out.gripper_rad = sample.gripper_rad;
  store(sample.gravity, out.gravity);
  out.buttons = sample.buttons;
  out.status = sample.status;
  out.fresh = sample.fresh;
  out.has_velocity = sample.has_velocity;
  store(command.force, out.force);
  store(command.torque, out.torque);
  out.gripper_force = command.gripper_force;
  out.enabled = command.enabled;
}

void restore(const LoggedDevice& in, DeviceSample& sample, DeviceCommand& command) HD_RT {
  sample.t_ns = in.t_ns;
  sample.p = vec3(in.p);
  sample.q = quat(in.q);
  sample.v = vec3(in.v);
  sample.w = vec3(in.w);
  sample.gripper_rad = in.gripper_rad;
  sample.gravity = vec3(in.gravity);
  sample.buttons = in.buttons;
  sample.status = in.status;
  sample.fresh = in.fresh;
  sample.has_velocity = in.has_velocity;
  command.force = vec3(in.force);
  command.torque = vec3(in.torque);
  command.gripper_force = in.gripper_force;
  command.enabled = in.enabled;
}

}  // namespace

void CycleLog::push(const CycleInput& input, const CycleOutput& output, std::uint32_t device_count) HD_RT {
  const std::uint64_t lost = lost_.load(std::memory_order_relaxed);
  // size() is never too small for the producer: what seems to fit does fit.
  if (lost != 0 || cycles_.size() == kCycles || kCommands - commands_.size() < input.command_count) {
    lost_.store(lost + 1, std::memory_order_relaxed);
    return;
  }
  for (std::uint32_t i = 0; i < input.command_count; ++i) (void)commands_.push(input.command[i]);
  LoggedCycle cycle{};
  cycle.tick = input.tick;
  cycle.now_ns = input.now_ns;
  cycle.missed = input.missed;
  cycle.command_count = input.command_count;
  cycle.stop_line = input.stop_line;
  cycle.deadman_open = input.deadman_open;
  for (std::uint32_t d = 0; d < device_count; ++d) note(input.device[d], output.device[d].command, cycle.device[d]);
  (void)cycles_.push(cycle);  // after its commands: who sees the cycle sees them
  pushed_.store(pushed_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

bool CycleLog::pop(LoggedCycle& cycle, std::array<Command, kMaxCommandsPerCycle>& command) HD_RT {
  if (!cycles_.pop(cycle)) return false;
  for (std::uint32_t i = 0; i < cycle.command_count; ++i) (void)commands_.pop(command[i]);
  return true;
}

void restore(const LoggedCycle& cycle, const std::array<Command, kMaxCommandsPerCycle>& commands, CycleInput& input,
             std::array<DeviceCommand, kMaxDevices>& sent) HD_RT {
  input.tick = cycle.tick;
  input.now_ns = cycle.now_ns;
  input.missed = cycle.missed;
  input.stop_line = cycle.stop_line;
  input.deadman_open = cycle.deadman_open;
  input.command_count = cycle.command_count;
  std::copy_n(commands.begin(), cycle.command_count, input.command.begin());
  for (std::uint32_t d = 0; d < kMaxDevices; ++d) restore(cycle.device[d], input.device[d], sent[d]);
}

}  // namespace hapticd
