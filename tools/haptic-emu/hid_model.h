/** @file
 * A HID device as the bus sees it, played report by report. Front ends put it before a driver: in_process_hid.h in the
 * same process and in virtual time.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/haptic-emu/fault.h"

namespace haptic_emu {

/** One device. Its clock is the front end's. Reports carry their ID only where the device numbers them. */
class HidModel {
 public:
  using Bytes = std::vector<std::uint8_t>;

  virtual ~HidModel() = default;

  [[nodiscard]] virtual const Bytes& descriptor() const = 0;
  /** The world goes on to t_ns, with whatever was sent before. Never back. */
  virtual void advance(std::int64_t t_ns) = 0;
  /** An output report; false: stalled. */
  [[nodiscard]] virtual bool out(std::span<const std::uint8_t> report) = 0;
  /** The oldest input report that waits. */
  [[nodiscard]] virtual std::optional<Bytes> in() = 0;
  /** Feature reports; false and nothing: stalled. */
  [[nodiscard]] virtual bool setFeature(std::span<const std::uint8_t>) { return false; }
  [[nodiscard]] virtual std::optional<Bytes> getFeature(std::uint8_t) { return std::nullopt; }

  [[nodiscard]] bool plugged() const { return !faults.active(FaultKind::kUnplug, now_ns_); }
  [[nodiscard]] std::int64_t now() const { return now_ns_; }
  /** How often it got its power, of one that forgets something with it. */
  [[nodiscard]] std::uint64_t pluggings() const { return pluggings_; }

  FaultPlan faults;

 protected:
  std::int64_t now_ns_ = 0;
  std::uint64_t pluggings_ = 0;
};

}  // namespace haptic_emu
