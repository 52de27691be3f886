/** @file
 * What a driver writes for a device whose library locks, allocates or blocks (libusb, serial lines, vendors'
 * libraries).
 */
#pragma once

#include <atomic>
#include <cstdint>

#include "drivers/link/device_link.h"
#include "rt/device.h"

namespace hapticd {

/**
 * The hardware's side of a device that is served by a thread of its own (IoDevice). Everything here is called by one
 * thread at a time, so a driver needs no lock; only info(), calibration() and safe() may be called by others meanwhile.
 */
class DeviceIo {
 public:
  virtual ~DeviceIo() = default;

  /** Fixed. */
  [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
  [[nodiscard]] virtual Calibration calibration() const noexcept { return Calibration::kNotNeeded; }
  /** As HasBattery. Any thread. */
  [[nodiscard]] virtual int batteryPercent() const noexcept { return -1; }

  /**
   * Takes the device and brings it up until exchange() can be called. No force. Called again after an unplug, every
   * half second, until it succeeds. Gives up early when `stop` turns true; never takes longer than some seconds.
   */
  [[nodiscard]] virtual Result<void> open(const std::atomic<bool>& stop) = 0;
  /** Zeros, then gives the device back. Also after a failed open() and when the device is gone; idempotent. */
  virtual void close() noexcept = 0;

  /**
   * Talks with the device, publishing every reading at once and sending what link.order(now, ...) gives, each time
   * anew and within that call. Returns at until_ns, or before. False: the device is gone.
   */
  [[nodiscard]] virtual bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept = 0;

  /** What the servo is told of a device that is gone; more than that for one that watches over others. */
  [[nodiscard]] virtual std::uint32_t statusWhenGone() const noexcept { return kDeviceGone; }

  /**
   * Zeros to the device at once, past the I/O thread, as far as that can be done in a signal handler (plain system
   * calls on an open descriptor). Nothing, if it cannot: the link sends zeros in the next exchange.
   */
  virtual void safe() noexcept = 0;
};

}  // namespace hapticd
