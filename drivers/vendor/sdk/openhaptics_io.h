/** @file
 * A Touch, Phantom or Omni through OpenHaptics' libHD.
 */
#pragma once

#include <atomic>
#include <optional>

#include "drivers/link/device_io.h"
#include "drivers/vendor/sdk/hd_sdk.h"
#include "drivers/vendor/sdk/pose_check.h"
#include "drivers/vendor/vendor_parameters.h"
#include "rt/base/clock.h"

namespace hapticd {

/**
 * The library's own scheduler calls tick() a thousand times a second on a thread of its own. That thread exchanges
 * with the link itself, which is wait-free, so nobody waits for anybody; exchange() only watches that the ticks go on.
 *
 * One device in a process. No force before it is calibrated or on a reading older than kTrust_ns.
 */
class OpenHapticsIo final : public DeviceIo {
 public:
  static constexpr std::int64_t kTrust_ns = 10'000'000;
  static constexpr std::int64_t kLook_ns = 1'000'000;
  static constexpr std::int64_t kSilent_ns = 50'000'000;   ///< No tick for so long: the scheduler is dead.
  static constexpr std::uint32_t kCalibrationEvery = 100;  ///< Ticks between two looks at it, while off.
  static constexpr int kMostErrors = 8;                    ///< Taken from the library's stack of errors in a tick.

  OpenHapticsIo(HdSetup setup, Clock& clock) : setup_(std::move(setup)), clock_(clock) {}
  ~OpenHapticsIo() override { close(); }
  OpenHapticsIo(const OpenHapticsIo&) = delete;
  OpenHapticsIo& operator=(const OpenHapticsIo&) = delete;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Calibration calibration() const noexcept override { return calibration_.load(); }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override {}  // No call into a closed library from a signal handler; the link sends zeros.

 private:
  class Inside;
  void describe();
  void tick() noexcept;
  void take(const double* transform, int buttons) noexcept;
  void send(const DeviceCommand& command) noexcept;
  void calibrate() noexcept;
  [[nodiscard]] std::uint32_t errors() noexcept;
  void leaveLink() noexcept;

  HdSetup setup_;
  Clock& clock_;
  std::optional<HdSdk> sdk_;
  HdSdk::Handle device_ = HdSdk::kNoDevice;
  unsigned long scheduled_ = 0;
  bool described_ = false;
  std::atomic<Calibration> calibration_{Calibration::kNeeded};
  std::atomic<DeviceLink*> link_{nullptr};  ///< Where ticks go; null: nowhere.
  std::atomic<bool> inside_{false};         ///< A tick is in it.
  std::atomic<std::int64_t> ticked_ns_{0};
  std::atomic<bool> gone_{false};
  // The scheduler's.
  PoseCheck check_;
  std::int64_t asked_ns_ = 0;
  bool asked_ = false, saturated_ = false, energised_ = false;
  std::uint32_t wrote_ = 0;  ///< DeviceStatus of what the last frame wrote.
  std::uint32_t ticks_ = 0;  ///< Wraps after 49 days.
};

}  // namespace hapticd
