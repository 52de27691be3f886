/** @file
 * A USB device as the bus sees it, played packet by packet. Front ends put it before a driver: in_process_usb.h in the
 * same process and in virtual time.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/usb/transport.h"
#include "tools/haptic-emu/fault.h"

namespace haptic_emu {

/** One device. Its clock is the front end's. */
class UsbModel {
 public:
  virtual ~UsbModel() = default;

  /** The world goes on to t_ns, with whatever was sent before. Never back. */
  virtual void advance(std::int64_t t_ns) = 0;
  /** A request without data; false: stalled. */
  [[nodiscard]] virtual bool control(const hapticd::UsbControl& request) = 0;
  /** A packet to its OUT endpoint. */
  virtual void out(std::span<const std::uint8_t> bytes) = 0;
  /** What its IN endpoint has to say now; nothing: not yet. */
  [[nodiscard]] virtual std::optional<std::vector<std::uint8_t>> in(std::size_t most) = 0;

  [[nodiscard]] bool plugged() const { return !faults.active(FaultKind::kUnplug, now_ns_); }
  [[nodiscard]] std::int64_t now() const { return now_ns_; }

  FaultPlan faults;

 protected:
  std::int64_t now_ns_ = 0;
};

}  // namespace haptic_emu
