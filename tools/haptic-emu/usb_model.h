/** @file
 * A USB device as the bus sees it, played packet by packet. Front ends put it before a driver: in_process_usb.h in the
 * same process and in virtual time.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/usb/transport.h"
#include "tools/haptic-emu/fault.h"

namespace haptic_emu {

/** Who it says it is. One configuration, one interface of the vendor's own class, two bulk endpoints. */
struct UsbIdentity {
  std::uint16_t vendor = 0, product = 0, version = 0x0100;
  std::string manufacturer, name, serial;
  std::uint8_t in = 0x81, out = 0x02;
  std::uint8_t packet_bytes = 64;
};

/** One device. Its clock is the front end's. */
class UsbModel {
 public:
  virtual ~UsbModel() = default;

  [[nodiscard]] virtual UsbIdentity identity() const = 0;

  /** Its time begins there. Before anything else. */
  void startAt(std::int64_t t_ns) { now_ns_ = t_ns; }
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
