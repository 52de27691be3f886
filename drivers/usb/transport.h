/** @file
 * A claimed USB interface as drivers see it: over libusb (libusb_transport.h), or played in the same process by a
 * model.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "rt/base/error.h"

namespace hapticd {

/** How a transfer ended. */
enum class UsbStatus : std::uint8_t { kOk, kTimeout, kStall, kGone, kCancelled, kError };
[[nodiscard]] std::string_view describe(UsbStatus status) noexcept;

/** A control request without data. */
struct UsbControl {
  std::uint8_t request_type = 0, request = 0;
  std::uint16_t value = 0, index = 0;
};

/** Which interface to claim, and the two bulk or interrupt endpoints to talk by. */
struct UsbInterface {
  std::uint8_t number = 0;
  std::uint8_t in = 0x81, out = 0x02;
  std::uint32_t packet_bytes = 64;
  bool interrupt = false;  ///< Interrupt endpoints instead of bulk.
};

/** Told of finished transfers, from within poll(). */
class UsbListener {
 public:
  virtual ~UsbListener() = default;
  /** `bytes` live until the call returns. */
  virtual void onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual void onOut(UsbStatus status) noexcept = 0;
};

/**
 * One claimed interface. Everything but sendNow() is called by one thread at a time. Transfers of a direction end in
 * the order they were posted. The destructor cancels what is under way and gives the interface back.
 */
class UsbTransport {
 public:
  /** Transfers under way at most, for each direction. */
  static constexpr std::size_t kMostPending = 4;

  virtual ~UsbTransport() = default;

  /** Waits for its end, up to a second. */
  [[nodiscard]] virtual UsbStatus control(const UsbControl& request) noexcept = 0;
  /** Asks for one packet. kError when kMostPending are under way. */
  [[nodiscard]] virtual UsbStatus postIn() noexcept = 0;
  /** Sends at most one packet; the bytes are copied. kError when kMostPending are under way. */
  [[nodiscard]] virtual UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept = 0;
  /** Returns when a transfer has ended and `listener` was told, or at until_ns of the driver's clock. */
  virtual void poll(std::int64_t until_ns, UsbListener& listener) noexcept = 0;
  /**
   * Sends one packet at once and waits for it some milliseconds, whatever else is under way. From any thread and from a
   * signal handler: no lock, no allocation.
   */
  virtual void sendNow(std::span<const std::uint8_t> bytes) noexcept = 0;
};

/** Finds and claims the device; called again after an unplug. */
using UsbOpener = std::function<Result<std::unique_ptr<UsbTransport>>()>;

}  // namespace hapticd
