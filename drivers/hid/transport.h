/** @file
 * What a driver needs of a HID device: reports in, reports out, features. Implemented over hidraw (hidraw_transport.h)
 * and, in tests, over a device model.
 *
 * Every report that goes out begins with its report ID, 0 where the device numbers none; every report that comes in
 * begins with its ID only if the device numbers its reports. That is how the kernel's hidraw and hidapi have it.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/** How an exchange with the device went. */
enum class HidResult : std::uint8_t {
  kOk,
  kNothing,  ///< No report within the time.
  kRefused,  ///< The device does not take or give this report; it is still there.
  kGone,     ///< Unplugged.
};

/** What a transport has open. */
struct HidPlugged {
  std::string device;    ///< Its IDs and its serial number: two of a kind without one have the same.
  std::string plugging;  ///< Another each time that anything is plugged in; "": nobody knows.
  /** Pluggings of what was there beside it when it was opened: none of these was it. */
  std::vector<std::string> beside{};
};

/**
 * One HID device. One thread at a time calls all of it, but for lastWords(). Reading never waits beyond its time.
 * Writing waits for the device: the kernel's usbhid gives it up to five seconds, so the servo must not write.
 */
class HidTransport {
 public:
  static constexpr std::size_t kLargestReport = 1024;  ///< Longest report in bytes that is read, its ID included.

  virtual ~HidTransport() = default;

  /**
   * Takes the device for itself. kNotFound: there is none like this; kPermissionDenied; kDeviceBusy: another hapticd
   * has it; kIo with what the system said.
   */
  [[nodiscard]] virtual Result<void> open() = 0;
  /** Idempotent. */
  virtual void close() noexcept = 0;
  /** The report descriptor, raw; empty before open. */
  [[nodiscard]] virtual const std::vector<std::uint8_t>& descriptor() const noexcept = 0;
  [[nodiscard]] virtual HidPlugged plugged() const { return {}; }

  /** CLOCK_MONOTONIC, or the model's time [ns]. */
  [[nodiscard]] virtual std::int64_t now() const noexcept = 0;
  /** The oldest report that waits, or the next one until `until_ns`. kOk sets `size` (at most buffer.size()). */
  [[nodiscard]] virtual HidResult read(std::span<std::uint8_t> buffer, std::size_t& size,
                                       std::int64_t until_ns) noexcept = 0;
  /** Sends an output report. */
  [[nodiscard]] virtual HidResult write(std::span<const std::uint8_t> report) noexcept = 0;
  /** Sends a feature report. */
  [[nodiscard]] virtual HidResult setFeature(std::span<const std::uint8_t> report) noexcept = 0;
  /** Asks for the feature report whose ID stands in buffer[0]; the answer begins with that ID. */
  [[nodiscard]] virtual HidResult getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept = 0;

  /** write() from any thread and from a signal handler; nothing when closed. What became of it is not known. */
  virtual void lastWords(std::span<const std::uint8_t> report) noexcept = 0;
};

/**
 * Reads until nothing waits and leaves the newest report in `buffer`: a device that the host fell behind is not
 * followed through its past. At most 64 reports, which is all that the kernel keeps. Waits for the first until
 * `until_ns`.
 */
[[nodiscard]] HidResult readNewest(HidTransport& transport, std::span<std::uint8_t> buffer, std::size_t& size,
                                   std::int64_t until_ns) noexcept;

}  // namespace hapticd
