/** @file
 * A device whose vendor's library runs in hapticd-vendor: the servo and that process share one piece of memory.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/link/slow_to_open.h"
#include "drivers/vendor/helper_process.h"
#include "drivers/vendor/shared_link.h"
#include "rt/base/clock.h"
#include "rt/cycle/realtime.h"
#include "rt/device.h"

namespace hapticd {

/** The memory of a link, sealed to its size; all zeros when made. Unmapped with it. */
class SharedLinkMapping {
 public:
  SharedLinkMapping() noexcept = default;
  SharedLinkMapping(const SharedLinkMapping&) = delete;
  SharedLinkMapping& operator=(const SharedLinkMapping&) = delete;
  ~SharedLinkMapping();
  /** Makes it, for the daemon. */
  [[nodiscard]] Result<void> make();
  /** Maps what came with a request. The descriptor is taken. */
  [[nodiscard]] Result<void> take(int descriptor);
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  [[nodiscard]] SharedLinkMemory* get() const noexcept { return memory_; }

 private:
  Result<void> map();
  int descriptor_ = -1;
  SharedLinkMemory* memory_ = nullptr;
};

/**
 * A closed library beside the servo could crash the daemon, write over its memory or hold its locks; so none is loaded
 * here. read() and write() touch the shared memory alone: no thread lies between servo and helper, and nobody waits.
 *
 * A helper that dies is told at once by its socket: kDeviceGone, a fault that latches, in the next reading even if
 * another has taken its place by then. Another is started in its place, which opens the device and so brings it to
 * zero; after that every half second until one succeeds. A helper whose daemon dies, or is silent for 10 ms, sends
 * zeros by itself.
 */
class HelperDevice final : public Device, public SlowToOpen {
 public:
  static constexpr int kOpen_ms = 15'000;  ///< Longest that a library may take to open its device.
  static constexpr int kRetry_ms = 500;

  /** `info` is what is known before it is open; its URI is the device's, and what the helper is told. */
  HelperDevice(DeviceInfo info, HelperOptions options, Clock& clock)
      : info_(std::move(info)), options_(std::move(options)), clock_(clock) {}
  ~HelperDevice() override { close(); }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] Calibration calibration() const noexcept override;
  [[nodiscard]] std::int64_t commandLife_ns() const noexcept override { return kCommandLife_ns; }
  [[nodiscard]] Histogram* roundTrip() noexcept override { return end_ ? &end_->round_trip : nullptr; }
  [[nodiscard]] Result<void> open() override;
  void close() noexcept override;
  void giveUp() noexcept override;
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override;
  void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT override { end_->write(now_ns, command); }
  [[nodiscard]] bool isOff() const noexcept override { return !end_ || end_->isOff(); }
  void safe() noexcept override;

  /** Of the running helper; 0 when there is none or systemd has started it. */
  [[nodiscard]] pid_t helper() const noexcept { return pid_.load(); }

 private:
  /** What it has opened; with `same`, no other than that. */
  [[nodiscard]] Result<DeviceInfo> startHelper(const DeviceInfo* same = nullptr);
  void watch() noexcept;
  /** False when close() asks for an end. */
  [[nodiscard]] bool waitUntilItEnds() noexcept;

  DeviceInfo info_;
  HelperOptions options_;
  Clock& clock_;
  SharedLinkMapping mapping_;
  std::unique_ptr<SharedServoEnd> end_;
  std::atomic<SharedServoEnd*> live_{nullptr};  ///< For safe().
  std::unique_ptr<HelperProcess> process_;      ///< open() and close(), and the watching thread between them.
  std::atomic<pid_t> pid_{0};
  std::atomic<bool> gone_{true}, stop_{false}, given_up_{false};
  std::atomic<bool> died_{false};       ///< A helper has ended that was open, and the servo has not read since.
  std::atomic<bool> told_gone_{false};  ///< The servo knows that the device has gone, and its calibration with it.
  std::uint32_t generation_ = 0;
  RtThread watcher_;
};

}  // namespace hapticd
