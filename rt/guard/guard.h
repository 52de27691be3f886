/** @file
 * The guard: the only way from computed forces to a device, and the last thing before it.
 *
 * Order (docs/safety.md): each source checked finite -> sum -> passivity -> arming ramp -> force, torque and power
 * limit
 * -> slew -> finite check. Slew binds increases and ordinary changes; a latched fault goes to zero in one tick and
 * stays until armed again. A lowered limit clamps at once.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/device.h"
#include "rt/guard/passivity.h"

namespace hapticd {

/** Bounds on what reaches the hand. All >= 0 and finite. */
struct GuardLimits {
  double force = 0;          ///< [N]
  double torque = 0;         ///< [N m]
  double force_slew = 0;     ///< [N/s]
  double torque_slew = 0;    ///< [N m/s]
  double gripper_force = 0;  ///< [N]
  double velocity = 0;       ///< Above it the guard latches [m/s].
  double power = 0;          ///< Most power delivered to the hand [W].
  double active_power = 0;   ///< Budget of active sources (client force, moving bodies, cues) [W].
};

/** Fixed behaviour; limits can change while running. */
struct GuardConfig {
  GuardLimits limits;
  std::int64_t ramp_ns = 2'000'000'000;  ///< Arming ramp from zero to full.
  double small_force = 0.2;              ///< The ramp starts once the force asked for stays below this [N] ...
  std::uint32_t small_force_ticks = 4;   ///< ... for so many ticks.
  std::int64_t stale_ns = 20'000'000;    ///< No fresh sample for so long: HD_FAULT_DEVICE_LOST.
  std::uint32_t missed_limit = 50;       ///< Periods missed in one overrun that latch HD_FAULT_OVERRUN.
  bool passivity = true;
};

/** What one tick asks of the device. */
struct GuardInput {
  std::int64_t now_ns = 0;
  double dt = 0;  ///< Nominal period [s].
  const DeviceSample* sample = nullptr;
  Twist velocity;                         ///< Estimated, of the device point.
  std::array<Wrench, HD_SOURCES> source;  ///< By hd_source; HD_SOURCE_GUARD unused.
  double gripper_force = 0;
  bool stop_line = false;  ///< Emergency stop is open.
  bool deadman_open = false;
  std::uint32_t missed = 0;  ///< Periods missed just before this tick.
};

struct GuardOutput {
  DeviceCommand command;
  std::array<Vec3, HD_SOURCES> by_source;  ///< Sums to command.force.
  std::uint32_t flags = 0;                 ///< hd_sample_flag bits of the guard.
  std::uint32_t fault = HD_FAULT_NONE;
  double energy = 0;  ///< Least of the observers' energies [J].
};

/** One device's guard. Servo thread only; hand-stepped in tests. */
class Guard {
 public:
  explicit Guard(const GuardConfig& config) noexcept;

  /** Starts waiting for small force, then the ramp. Clears a fault whose cause is gone; kFaultLatched if it is not. */
  ErrorCode arm() HD_RT;
  /** Ramps down at the slew limit, then off. */
  void disarm() HD_RT;
  /** Latches `cause` (hd_fault): zero from this tick on. */
  void latch(std::uint32_t cause) HD_RT;
  /** Clamps at once where lower. kInvalidArgument if not finite or negative: nothing changes. */
  ErrorCode setLimits(const GuardLimits& limits) HD_RT;

  void step(const GuardInput& input, GuardOutput& output) HD_RT;

  [[nodiscard]] const GuardLimits& limits() const HD_RT { return config_.limits; }
  [[nodiscard]] bool armed() const HD_RT { return state_ != State::kDisarmed && fault_ == HD_FAULT_NONE; }
  [[nodiscard]] std::uint32_t fault() const HD_RT { return fault_; }

 private:
  enum class State : std::uint8_t { kDisarmed, kWaiting, kArmed, kLowering };

  std::uint32_t causeOf(const GuardInput& input) const HD_RT;

  GuardConfig config_;
  State state_ = State::kDisarmed;
  std::uint32_t fault_ = HD_FAULT_NONE;
  std::uint32_t present_cause_ = HD_FAULT_NONE;  ///< Cause seen in the last tick, whether latched or not.
  std::uint32_t small_ticks_ = 0;
  double ramp_ = 0;
  std::int64_t last_fresh_ns_ = 0;
  Vec3 last_force_ = Vec3::Zero();
  Vec3 last_torque_ = Vec3::Zero();
  Passivity passivity_;
};

}  // namespace hapticd
