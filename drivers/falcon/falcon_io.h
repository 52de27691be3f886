/** @file
 * A Falcon as it runs: orders and readings in turn, homing, and what to make of readings that cannot be.
 */
#pragma once

#include <atomic>
#include <memory>

#include "drivers/falcon/falcon_kinematics.h"
#include "drivers/falcon/falcon_parameters.h"
#include "drivers/falcon/falcon_protocol.h"
#include "drivers/link/device_io.h"
#include "drivers/link/lent.h"
#include "drivers/link/reading_check.h"
#include "rt/base/clock.h"

namespace hapticd {

/**
 * One question, one answer: an order goes out as soon as the last was answered, while two requests for the answer are
 * posted already; so the device sets the pace, about a thousand a second.
 *
 * No force before all three arms are homed: until then the grip's place is unknown, and it jumps when they are. Lights:
 * red until then, blue after, green while force is on. A reading that cannot be (an arm faster than kMostCountsPerMs,
 * angles without a place) is dropped; kBadInARow of them are a device error. A force is only sent on a reading younger
 * than kTrust_ns. Silence for kSilent_ns counts as gone: the motors have a supply of their own, and without it the USB
 * side is still there.
 */
class FalconIo final : public DeviceIo, private UsbListener {
 public:
  static constexpr std::int64_t kAnswer_ns = 10'000'000;
  static constexpr std::int64_t kTrust_ns = 10'000'000;
  static constexpr std::int64_t kSilent_ns = 1'000'000'000;
  static constexpr double kMostCountsPerMs = 250;  ///< About 10 m/s at the grip.
  static constexpr int kBadInARow = 10;
  static constexpr int kFewBad = 3;  ///< In a row: from there on no force.
  static constexpr int kZeros = 3;   ///< Packets on every way out, for there is no acknowledgement.

  FalconIo(FalconSetup setup, Clock& clock) : setup_(std::move(setup)), clock_(clock) {}
  ~FalconIo() override { close(); }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Calibration calibration() const noexcept override { return calibration_.load(); }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override;

 private:
  void onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept override;
  void onOut(UsbStatus status) noexcept override;

  void sendOrder(DeviceLink& link) noexcept;
  [[nodiscard]] falcon::Order orderFor(const DeviceCommand& command) noexcept;
  void take(const falcon::Reading& reading, DeviceLink& link) noexcept;
  [[nodiscard]] double movedTo(const falcon::Reading& reading) const noexcept;
  void forget() noexcept;

  FalconSetup setup_;
  Clock& clock_;
  std::unique_ptr<UsbTransport> usb_;
  Lent<UsbTransport*, nullptr> live_;  ///< For safe().
  std::atomic<Calibration> calibration_{Calibration::kNeeded};

  falcon::Parser parser_;
  std::uint64_t dropped_ = 0;  ///< Of the parser's, counted already.
  bool gone_ = false;
  bool asked_ = false;  ///< An order waits for its answer.
  bool homed_ = false;
  bool saturated_ = false;
  std::size_t under_way_ = 0;  ///< Orders whose transfer has not ended.
  bool not_taken_ = false;     ///< One has failed since the last was sent.
  int unasked_ = 0;  ///< Requests that failed, to go out with the next order: at once they could fail without end.
  ReadingCheck check_{kMostCountsPerMs, kBadInARow};  ///< Of readings since homing, as `last_` and `grip_` are.
  std::int64_t asked_ns_ = 0, heard_ns_ = 0;
  falcon::Reading last_;
  falcon::Grip grip_;
};

}  // namespace hapticd
