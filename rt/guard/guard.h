/** @file
 * The guard: the only way from computed forces to a device, and the last thing before it.
 *
 * Order (docs/safety.md): each source checked finite -> sum -> passivity -> arming ramp -> force, torque, gripper and
 * power limit -> slew -> finite check. Slew binds increases and ordinary changes; a latched fault goes to zero in one
 * tick and stays until armed again. A lowered limit clamps at once.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/error.h"
#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/device.h"
#include "rt/guard/buzz_velocity.h"
#include "rt/guard/guard_limits.h"
#include "rt/guard/heating.h"
#include "rt/guard/passivity.h"
#include "rt/guard/past_forces.h"

namespace hapticd {

/** Fixed behaviour; limits can change while running. */
struct GuardConfig {
  GuardLimits limits;
  std::int64_t ramp_ns = 2'000'000'000;  ///< Arming ramp from zero to full.
  double small_force = 0.2;              ///< The ramp starts once the force asked for stays below this [N] ...
  double small_torque = 0.02;            ///< ... and the torque below this [N m] ...
  std::uint32_t small_force_ticks = 4;   ///< ... for so many ticks. Gravity compensation does not count.
  std::int64_t stale_ns = 20'000'000;    ///< No fresh sample for so long: HD_FAULT_DEVICE_LOST.
  /** So long does the device show a command that no other follows, and then nothing; 0: until the next. */
  std::int64_t life_ns = 0;
  std::uint32_t missed_limit = 50;  ///< Periods missed in one overrun that latch HD_FAULT_OVERRUN.
  bool passivity = true;
  double delay = 0;        ///< From a command to the sample that shows it act, beyond one tick [ticks, at most 16].
  double max_damping = 2;  ///< What the device can show [N s/m]: most that the passivity controller adds.
  double continuous_force = 0;  ///< What the motors stand for ever [N]; 0: unknown, no heating estimate.
  double peak_force = 0;        ///< What they stand for a while [N].
  double heating_s = 30;        ///< Time constant of their heating.
  double heat = 0;              ///< Where the estimate begins.
  double energy_limit = 0.25;   ///< Passive sources gave so much more than they got [J]: HD_FAULT_ENERGY.
};

/** What one tick asks of the device, in its frame. */
struct GuardInput {
  std::int64_t now_ns = 0;
  double dt = 0;                          ///< Nominal period [s].
  const DeviceSample* sample = nullptr;   ///< There must be one.
  Twist velocity;                         ///< Estimated, of the device point.
  std::array<Wrench, HD_SOURCES> source;  ///< By hd_source; HD_SOURCE_GUARD unused.
  double gripper_force = 0;
  bool stop_line = false;  ///< Emergency stop is open.
  bool deadman_open = false;
  std::uint32_t missed = 0;  ///< Periods missed just before this tick.

  /** Part of source[HD_SOURCE_LOCAL_MODEL] that springs and force fields make: active, not passive [N]. */
  Vec3 local_active = Vec3::Zero();
  /** Part of source[HD_SOURCE_TEXTURE] that a relief makes: passive, with its surface; the rest is active [N]. */
  Vec3 relief = Vec3::Zero();
  /** Power, by axis, that clients put into passive sources by moving them: force times velocity of the body [W]. */
  Vec3 carried = Vec3::Zero();
  /** Elastic energy that the passive sources hold now [J]; negative: unknown. */
  double stored = -1;
  /** What surface, models and drags damp by [N s/m]: what the passivity controller adds comes on top of it. */
  double damping = 0;
};

struct GuardOutput {
  DeviceCommand command;
  std::array<Vec3, HD_SOURCES> by_source;  ///< Sums, in order, to command.force exactly.
  std::uint32_t flags = 0;                 ///< hd_sample_flag bits of the guard.
  std::uint32_t fault = HD_FAULT_NONE;
  double energy = 0;  ///< What the passivity observer holds [J]; negative: active.
  double heat = 0;    ///< Of the motors, 1: all they stand for ever.
  bool warm = false;  ///< The force will be derated if this goes on, or is already.
};

/**
 * One device's guard. Servo thread only; hand-stepped in tests. Whatever enters: |force| <= limits.force and so on, and
 * |change| <= slew dt but for the falls of docs/safety.md (fault, lowered limit, end of lowering, a slew limit so slow
 * that the force would hang).
 */
class Guard {
 public:
  /** Disarming takes at most this long: what the slew limit has not lowered by then goes to zero at once. */
  static constexpr double kLower_s = 1.0;
  /** However slow the slew limit, what only becomes smaller does so at least as fast as by its own size in this time.
   */
  static constexpr double kFall_s = 0.25;
  /** Bodies that clients move by steps, at their own rate, are charged for the average over this time. */
  static constexpr double kCarried_s = 50e-3;

  /** Limits that setLimits() would refuse become zero: nothing passes. */
  explicit Guard(const GuardConfig& config) noexcept;

  /**
   * Starts waiting for small force, then the ramp. Clears a fault whose cause is gone. kFaultLatched while a cause
   * stands (fault() then names it); nothing else changes. Armed already: nothing happens.
   */
  ErrorCode arm() HD_RT;
  /** Lowers to zero at the slew limit, in min(force / slew, kLower_s), then off. */
  void disarm() HD_RT;
  /** Latches `cause` (hd_fault): zero from this tick on. The first cause stays. */
  void latch(std::uint32_t cause) HD_RT;
  /** Clamps at once where lower. kInvalidArgument if not finite or negative: nothing changes. */
  ErrorCode setLimits(const GuardLimits& limits) HD_RT;

  /** Encoder step of the device [m]; 0: exact. Before the first step. */
  void setResolution(double step) HD_RT { v_buzz_.setResolution(step); }

  void step(const GuardInput& input, GuardOutput& output) HD_RT;

  [[nodiscard]] const GuardLimits& limits() const HD_RT { return config_.limits; }
  /** Waiting, ramping, in full force or being lowered: the amplifiers may be on. */
  [[nodiscard]] bool armed() const HD_RT { return state_ != State::kDisarmed && fault_ == HD_FAULT_NONE; }
  [[nodiscard]] std::uint32_t fault() const HD_RT { return fault_; }
  [[nodiscard]] double heat() const HD_RT { return heating_.heat(); }
  /** Its books, by the device's axes. */
  [[nodiscard]] const Passivity& passivity() const HD_RT { return passivity_; }

 private:
  enum class State : std::uint8_t { kDisarmed, kWaiting, kArmed, kLowering };

  /** What is asked for, finite, on the grid, split as the stages need it. */
  struct Wanted {
    std::array<Vec3, HD_SOURCE_GUARD> by_source;
    Vec3 passive = Vec3::Zero();  ///< Surface with its relief, and local contact models.
    Vec3 active = Vec3::Zero();   ///< Effects, springs, fields, client forces, vibrations, transients.
    Vec3 gravity = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
    double gripper = 0;
    Vec3 carried = Vec3::Zero();
  };
  /** What went out. */
  struct Sent {
    Vec3 force = Vec3::Zero();
    Vec3 torque = Vec3::Zero();
    double gripper = 0;

    [[nodiscard]] bool isNothing() const HD_RT { return force.isZero(0) && torque.isZero(0) && gripper == 0; }
  };

  /** False when anything is not finite; by_source then has zeros in its place. */
  [[nodiscard]] static bool gather(const GuardInput& input, Wanted& wanted) HD_RT;
  [[nodiscard]] std::uint32_t causeOf(const GuardInput& input, bool sources_finite) const HD_RT;
  /** Elastic energy the passive sources hold now [J]; negative: unknown. */
  [[nodiscard]] static double storedIn(const GuardInput& input, const Wanted& wanted) HD_RT;
  /** Whether the driver has sent zeros since the last tick, because this one came so late. */
  [[nodiscard]] bool takenBack(const GuardInput& input) const HD_RT;
  /** Part of the time since the last tick in which the device showed what it was sent there, in (0, 1]. */
  [[nodiscard]] double stoodFor(const GuardInput& input) const HD_RT;
  void forgetEnergy() HD_RT;
  void bookEnergy(const GuardInput& input, const Wanted& wanted) HD_RT;
  void advanceState(const Wanted& wanted, const GuardInput& input) HD_RT;
  [[nodiscard]] Sent pass(const GuardInput& input, const Wanted& wanted, std::uint32_t& flags) HD_RT;
  [[nodiscard]] Sent limit(const GuardInput& input, const Wanted& wanted, const Sent& target,
                           std::uint32_t& flags) const HD_RT;
  [[nodiscard]] Sent slew(const Sent& target, double dt) const HD_RT;

  GuardConfig config_;
  State state_ = State::kDisarmed;
  std::uint32_t fault_ = HD_FAULT_NONE;
  std::uint32_t present_cause_ = HD_FAULT_NONE;  ///< Cause seen in the last tick, whether latched or not.
  std::uint32_t small_ticks_ = 0;
  std::int64_t ramped_ns_ = 0;
  double ramp_ = 0;
  double ramp_rose_ = 0;  ///< In this tick, as a part of ramp_.
  double lowered_s_ = 0;
  bool started_ = false;
  std::int64_t last_fresh_ns_ = 0;
  Vec3 last_p_ = Vec3::Zero();
  Sent last_;
  Vec3 last_passive_ = Vec3::Zero();  ///< Passive part of last_.force.
  PastForces past_passive_;           ///< last_passive_ of the last ticks.
  double last_share_ = 0;             ///< Part of what was wanted that was sent.
  double last_stored_ = -1;  ///< Elastic energy of the passive sources in the last tick [J]; negative: unknown.
  BuzzVelocity v_buzz_;
  Vec3 last_carried_ = Vec3::Zero();  ///< Energy carried in over the last tick, for each period that it lasts [J],
  Vec3 last_ramped_ = Vec3::Zero();   ///< and what the ramp's rise added to what is stored.
  double carried_power_ = 0;          ///< Carried power, averaged over kCarried_s [W].
  Passivity passivity_;
  Heating heating_;
};

}  // namespace hapticd
