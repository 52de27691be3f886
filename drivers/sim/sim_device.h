/** @file
 * The simulated device: sim://PRESET?key=value. A dynamics model with a hand, not a stub: forces move it.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "drivers/link/holds_memory.h"
#include "drivers/link/slow_to_open.h"
#include "drivers/sim/body.h"
#include "drivers/sim/motion.h"
#include "drivers/sim/sim_parameters.h"
#include "rt/device.h"

namespace hapticd {

/**
 * The device has a clock of its own with `rate` periods per second, in step with multiples of the period on the time
 * axis of now_ns, as a servo's deadlines are. Whatever happens within one period counts as simultaneous, so the
 * trajectory does not depend on how late in its period a call comes. Each period is cut into equal sub-steps of at most
 * 62.5 us, integrated exactly (linear_step.h).
 *
 * A gap longer than kMaxCatchUp_s in now_ns advances the simulated world by that much only and skips the rest:
 * skippedPeriods() counts it. After it, hand and device go on from where they were.
 *
 * read, write and setIntent are real-time safe and called by one thread; safe() by any.
 */
class SimDevice final : public Device, public SlowToOpen, public HoldsMemory {
 public:
  static constexpr double kMaxSubStep_s = 62.5e-6;
  static constexpr double kMaxCatchUp_s = 0.02;
  static constexpr std::uint32_t kMaxDelay = 64;

  explicit SimDevice(SimSetup setup);

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Result<void> open() override;
  void giveUp() noexcept override { given_up_.store(true, std::memory_order_relaxed); }
  void close() noexcept override;
  [[nodiscard]] std::size_t heldBytes() const noexcept override { return held_bytes_; }
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override;
  void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT override;
  void setIntent(const DeviceIntent& intent) HD_RT override { motion_.setLive(intent); }
  void safe() noexcept override;

  /** Periods skipped after gaps. */
  [[nodiscard]] std::uint64_t skippedPeriods() const HD_RT { return skipped_; }
  /** The truth behind the encoders, for tests: unquantised, undelayed. */
  [[nodiscard]] const PointBody& body() const HD_RT { return point_; }
  [[nodiscard]] const RotatingBody& rotation() const HD_RT { return rotating_; }
  /** The force that acts now, after resolution, saturation and delay. */
  [[nodiscard]] const DeviceCommand& acting() const HD_RT { return acting_; }

 private:
  struct Pending {
    std::int64_t period = -1;
    DeviceCommand command;
    std::uint32_t status = kDeviceOk;
  };

  /** That recorded motion; null: it is not open. */
  void play(std::shared_ptr<const PoseTrack> track);
  void advanceTo(std::int64_t now_ns) HD_RT;
  void runPeriod() HD_RT;
  void measure() HD_RT;
  [[nodiscard]] Pending limited(const DeviceCommand& command) const HD_RT;

  SimSetup setup_;
  std::int64_t period_ns_;
  int sub_steps_;
  double sub_step_s_;
  PointBody point_, gripper_;
  RotatingBody rotating_;
  IntendedMotion motion_;
  std::size_t held_bytes_ = 0;  ///< Of a recorded motion.

  bool started_ = false;
  std::int64_t offset_ = 0;  ///< Period on the axis of now_ns minus simulated period.
  std::int64_t period_ = 0;  ///< Simulated periods since start; the state stands at its beginning.
  std::int64_t reported_ = -1;
  std::uint64_t skipped_ = 0;
  DeviceCommand acting_;
  std::uint32_t acting_status_ = kDeviceOk;
  std::array<Pending, kMaxDelay + 1> pending_;        ///< By period modulo size.
  std::array<DeviceSample, kMaxDelay + 1> measured_;  ///< By period modulo size.
  std::atomic<bool> safe_{false};  ///< Set by safe() (release), taken by the next read or write (acquire).
  std::atomic<bool> given_up_{false};
};

}  // namespace hapticd
