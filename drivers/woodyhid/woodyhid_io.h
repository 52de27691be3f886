/** @file
 * WoodenHaptics and Polhem at work: one report out for each that comes in.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/link/device_io.h"
#include "drivers/link/reading_check.h"
#include "drivers/woodyhid/woody_kinematics.h"
#include "drivers/woodyhid/woodyhid_parameters.h"
#include "drivers/woodyhid/woodyhid_protocol.h"

namespace hapticd {

/**
 * The encoders count from wherever the arm was when it got its power. So nothing is published, and nothing pushed,
 * until the user has put the arm into its pose of calibration and pressed the button on the electronics. A press from
 * before the start, or while the motors were on, says nothing of the pose now: it is wiped, not obeyed. What it reads
 * is by the new counters from the first report on that shows the button up: of those before, one may have been on its
 * way already, and where two orders came at once the firmware has dropped the first.
 */
class WoodyIo final : public DeviceIo {
 public:
  static constexpr std::int64_t kKick_ns = 10'000'000;        ///< Silence after which the device is spoken to.
  static constexpr std::int64_t kFirstWord_ns = 500'000'000;  ///< Silence after open that says it is another device.
  static constexpr std::int64_t kTrust_ns = 10'000'000;  ///< Age of a reading by which forces may still be computed.
  static constexpr std::int64_t kRefusing_ns = 200'000'000;  ///< One that takes nothing for so long counts as gone.
  static constexpr int kZeros = 3;                           ///< Attempts at it, when it is closed and does not hang.
  static constexpr double kMostCountsPerMs = 200;            ///< Of a motor: twice what a hand does at 2 m/s.
  static constexpr int kBadInARow = 20;
  static constexpr int kStill = 5;  ///< Reports without a motion after which the arm is where the last one says.
  static constexpr int kDeaf = 5;   ///< Reports after which a device that shows no new counters is told them again.

  explicit WoodyIo(WoodySetup setup) : setup_(std::move(setup)), hid_(setup_.hid()) {}
  ~WoodyIo() override { close(); }
  WoodyIo(const WoodyIo&) = delete;
  WoodyIo& operator=(const WoodyIo&) = delete;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Calibration calibration() const noexcept override { return calibration_.load(); }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override;

 private:
  /** As exchange(). */
  [[nodiscard]] bool talk(DeviceLink& link, std::int64_t until_ns) noexcept;
  /** Only the button makes it good. */
  void countsLost() noexcept;
  HidResult send(const woodyhid::Report& report) noexcept;
  [[nodiscard]] double movedTo(const woodyhid::Reading& reading) const noexcept;
  void take(const woodyhid::Reading& reading, std::int64_t now_ns, DeviceLink& link) noexcept;
  void publish(const woodyhid::Reading& reading, std::int64_t now_ns, DeviceLink& link) noexcept;
  [[nodiscard]] bool reply(const woodyhid::Reading* reading, std::int64_t now_ns, DeviceLink& link) noexcept;
  [[nodiscard]] woodyhid::Report answer(const woodyhid::Reading* reading, const DeviceCommand& command,
                                        std::int64_t now_ns) noexcept;

  WoodySetup setup_;
  std::unique_ptr<HidTransport> hid_;
  /** Of what goes out, its ID included. safe() may come before it is known; any board takes as much as this. */
  std::atomic<std::size_t> report_bytes_{1 + woodyhid::kReportBytes};
  std::atomic<Calibration> calibration_{Calibration::kNeeded};
  std::shared_ptr<WoodyPlugged> plugged_;
  bool may_press_ = false;    ///< The button was seen up while the motors were off.
  bool calibrating_ = false;  ///< It was told the counters of calibration; its button is not up yet.
  int deaf_ = 0;              ///< Reports since then.
  std::array<std::int32_t, 6> heard_{};
  int still_ = 0;  ///< Reports in a row with the same encoders.
  ReadingCheck check_{kMostCountsPerMs, kBadInARow};
  woodyhid::Reading last_;
  WoodyArm arm_;
  std::int64_t sent_ns_ = 0, taken_ns_ = 0;  ///< The last report that went out, and that was not refused.
  bool asked_ = false;                       ///< Something was sent since the last reading.
  bool saturated_ = false;
};

}  // namespace hapticd
