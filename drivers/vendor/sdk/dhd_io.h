/** @file
 * A device of Force Dimension through libdhd.
 */
#pragma once

#include <atomic>
#include <optional>

#include "drivers/link/device_io.h"
#include "drivers/vendor/sdk/dhd_sdk.h"
#include "drivers/vendor/sdk/pose_check.h"
#include "drivers/vendor/vendor_parameters.h"
#include "rt/base/clock.h"

namespace hapticd {

/**
 * A thousand times a second: where it is, then what to push with. The library speaks to the device within each call.
 * No force before the device says that it is calibrated, on a reading older than kTrust_ns, or after it has switched
 * its forces off by itself (its button, its own velocity limit), which counts as a dead-man switch let go.
 */
class DhdIo final : public DeviceIo {
 public:
  static constexpr std::int64_t kPeriod_ns = 1'000'000;
  static constexpr std::int64_t kTrust_ns = 10'000'000;
  static constexpr int kFailuresInARow = 10;         ///< Readings or forces that fail: it is gone.
  static constexpr std::uint32_t kStatusEvery = 50;  ///< Ticks between two looks at its state.
  static constexpr int kZeros = 3;

  DhdIo(DhdSetup setup, Clock& clock) : setup_(std::move(setup)), clock_(clock) {}
  ~DhdIo() override { close(); }
  DhdIo(const DhdIo&) = delete;
  DhdIo& operator=(const DhdIo&) = delete;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Calibration calibration() const noexcept override { return calibration_.load(); }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override {}  // No call into a closed library from a signal handler; the link sends zeros.

 private:
  [[nodiscard]] Error failed(const char* what) const;
  [[nodiscard]] Result<void> describe();
  [[nodiscard]] bool read(DeviceSample& sample) noexcept;
  void take(DeviceSample& sample, DeviceLink& link) noexcept;
  /** Whether it was taken: of a command that is off, that forces are off or zero. */
  [[nodiscard]] bool send(const DeviceCommand& command) noexcept;
  void lookAtStatus() noexcept;
  /** Whether it was taken. */
  bool setForce(const Vec3& force, const Vec3& torque, double gripper) noexcept;

  DhdSetup setup_;
  Clock& clock_;
  std::optional<DhdSdk> sdk_;
  DhdSdk::Id id_ = 0;
  bool open_ = false, wrist_ = false, gripper_ = false;
  int jaws_ = 1;         ///< -1: the gripper of a left-handed device opens toward negative angles.
  int system_type_ = 0;  ///< 0: never opened.
  std::atomic<Calibration> calibration_{Calibration::kNeeded};
  PoseCheck check_;
  std::int64_t next_ns_ = 0, asked_ns_ = 0;
  bool asked_ = false, saturated_ = false, energised_ = false, switched_off_ = false;
  bool may_push_ = false;  ///< It was told to, and has not taken since that it is not.
  int failures_ = 0, refusals_ = 0;
  std::uint32_t ticks_ = 0, energised_ticks_ = 0;  ///< They wrap after 49 days.
};

}  // namespace hapticd
