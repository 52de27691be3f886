/** @file
 * A device served by a thread of its own: DeviceIo below, the Device interface above, a DeviceLink between.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "drivers/link/device_io.h"
#include "drivers/link/has_battery.h"
#include "drivers/link/slow_to_open.h"
#include "rt/base/clock.h"
#include "rt/cycle/realtime.h"
#include "rt/device.h"

namespace hapticd {

struct IoOptions {
  int priority = 85;                        ///< SCHED_FIFO; without the right to it the thread runs as others do.
  bool thread = true;                       ///< False: the caller runs it by pump() (tests, benchmarks).
  std::int64_t stale_ns = kCommandLife_ns;  ///< A servo silent for so long has its force taken back.
  std::int64_t retry_ns = 500'000'000;      ///< Between two attempts to find an unplugged device again.
  std::int64_t in_flight_ns = 2'000'000;    ///< Longest wait of safe() for an order that is being sent.
  std::int64_t service_ns = 50'000'000;     ///< Longest stay in one exchange(), and so until close() is noticed.
};

/**
 * Reads and writes of the servo touch only the link. A device that goes shows kDeviceGone, which the guard latches as a
 * fault; when it is there again it is opened anew and samples go on. Nothing moves until somebody arms again.
 */
class IoDevice final : public Device, public SlowToOpen, public HasBattery {
 public:
  explicit IoDevice(std::unique_ptr<DeviceIo> io, IoOptions options = {});
  IoDevice(std::unique_ptr<DeviceIo> io, IoOptions options, Clock& clock);
  ~IoDevice() override { close(); }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return io_->info(); }
  /** Of a device that needs one, none from the moment the servo is told that it has gone. */
  [[nodiscard]] Calibration calibration() const noexcept override;
  [[nodiscard]] int batteryPercent() const noexcept override { return io_->batteryPercent(); }
  [[nodiscard]] std::int64_t commandLife_ns() const noexcept override { return options_.stale_ns; }
  [[nodiscard]] Histogram* roundTrip() noexcept override { return &link_.round_trip; }

  [[nodiscard]] Result<void> open() override;
  void close() noexcept override;
  void giveUp() noexcept override;
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override { link_.read(now_ns, sample); }
  void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT override { link_.write(now_ns, command); }
  [[nodiscard]] bool isOff() const noexcept override { return link_.isOff(); }
  void safe() noexcept override;

  /** Without a thread: serves the device until the clock stands at until_ns. */
  void pump(std::int64_t until_ns) noexcept;

  [[nodiscard]] DeviceLink& link() noexcept { return link_; }
  /** Why the thread is not real-time; "" when it is. */
  [[nodiscard]] const std::string& schedulingNote() const noexcept { return note_; }

 private:
  void serve(std::int64_t until_ns) noexcept;
  void lookAgain(std::int64_t until_ns) noexcept;

  std::unique_ptr<DeviceIo> io_;
  IoOptions options_;
  MonotonicClock monotonic_;
  Clock& clock_;
  DeviceLink link_;
  RtThread thread_;
  std::atomic<bool> stop_{false}, given_up_{false};
  bool open_ = false;
  std::atomic<bool> there_{false};  ///< Written by the I/O thread.
  std::int64_t next_look_ns_ = 0;
  std::string note_;
};

/** What a driver makes of a URI: the device by way of `Io`, or why there is none. */
template <class Io, class Setup, class... More>
[[nodiscard]] Result<std::unique_ptr<Device>> makeIoDevice(Result<Setup> setup, More&... more) {
  if (!setup) return setup.error();
  return std::unique_ptr<Device>(std::make_unique<IoDevice>(std::make_unique<Io>(std::move(*setup), more...)));
}

}  // namespace hapticd
