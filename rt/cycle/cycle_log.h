/** @file
 * What the servo leaves for the recorder: each cycle's input and the command it came to, in two rings of fixed size.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "rt/cycle/cycle.h"
#include "rt/ring/spsc.h"

namespace hapticd {

/** A DeviceSample and a DeviceCommand as plain numbers, bit for bit. */
struct LoggedDevice {
  std::int64_t t_ns;
  double p[3], q[4], v[3], w[3];  ///< q: w x y z.
  double gripper_rad;
  double gravity[3];
  std::uint32_t buttons;
  std::uint32_t status;
  double force[3], torque[3];
  double gripper_force;
  bool fresh, has_velocity, enabled;
};

/** One cycle. Its commands stand in the other ring. */
struct LoggedCycle {
  std::uint64_t tick;
  std::int64_t now_ns;
  std::uint32_t missed;
  std::uint32_t command_count;
  bool stop_line, deadman_open;
  std::array<LoggedDevice, kMaxDevices> device;
};

/**
 * One producer, the servo; one consumer, the recorder. A log has no holes: the first cycle that finds no room ends it,
 * and that cycle and all later ones are counted as lost. Allocates nothing after construction.
 */
class CycleLog {
 public:
  static constexpr std::uint32_t kCycles = 4096;    ///< Four seconds at 1 kHz, one at 4 kHz.
  static constexpr std::uint32_t kCommands = 8192;  ///< 128 cycles of the most commands a cycle takes.

  /** Servo, once a cycle, when the force is out. */
  void push(const CycleInput& input, const CycleOutput& output, std::uint32_t device_count) HD_RT;

  /** Recorder. False when there is none; else `cycle.command_count` of `command` are set. */
  bool pop(LoggedCycle& cycle, std::array<Command, kMaxCommandsPerCycle>& command) HD_RT;

  /** Cycles pushed so far. Any thread; acquire: what the servo did before the last of them is visible. */
  [[nodiscard]] std::uint64_t pushed() const HD_RT { return pushed_.load(std::memory_order_acquire); }
  /** Cycles that found no room. Any thread. */
  [[nodiscard]] std::uint64_t lost() const HD_RT { return lost_.load(std::memory_order_relaxed); }

 private:
  SpscRing<LoggedCycle, kCycles> cycles_;
  SpscRing<Command, kCommands> commands_;
  std::atomic<std::uint64_t> pushed_{0};
  std::atomic<std::uint64_t> lost_{0};
};

/** The input and what was sent, as the cycle had them. `commands` are those of the cycle. */
void restore(const LoggedCycle& cycle, const std::array<Command, kMaxCommandsPerCycle>& commands, CycleInput& input,
             std::array<DeviceCommand, kMaxDevices>& sent) HD_RT;

}  // namespace hapticd
