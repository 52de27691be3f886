/** @file
 * A board on a serial line, played byte by byte, and the line to a driver in the same process, in virtual time.
 */
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <span>

#include "drivers/serial/transport.h"
#include "rt/base/clock.h"
#include "tools/haptic-emu/fault.h"

namespace haptic_emu {

class SerialModel {
 public:
  virtual ~SerialModel() = default;

  /** The world goes on to t_ns. Never back. */
  virtual void advance(std::int64_t t_ns) = 0;
  virtual void hear(std::span<const std::uint8_t> bytes) = 0;
  /** What it has said by now. */
  std::deque<std::uint8_t> said;
  bool deaf = false;  ///< Takes nothing: the line fills up.

  [[nodiscard]] bool plugged() const { return !faults.active(FaultKind::kUnplug, now_ns_); }
  FaultPlan faults;

 protected:
  std::int64_t now_ns_ = 0;
};

/** Waiting in read() moves `clock`, and with it the model. Both outlive it. */
class InProcessSerial final : public hapticd::SerialTransport {
 public:
  InProcessSerial(SerialModel& model, hapticd::Clock& clock) : model_(model), clock_(clock) {}

  [[nodiscard]] hapticd::Result<void> open() override {
    model_.advance(clock_.now());
    if (!model_.plugged())
      return hapticd::Error{hapticd::ErrorCode::kNotFound, "played line", "unplugged", "plug it in"};
    open_ = true;
    model_.said.clear();
    return {};
  }
  void close() noexcept override { open_ = false; }
  [[nodiscard]] std::int64_t now() const noexcept override { return clock_.now(); }
  [[nodiscard]] bool read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept override {
    constexpr std::int64_t kStep_ns = 125'000;
    size = 0;
    while (there()) {
      for (; size < buffer.size() && !model_.said.empty(); model_.said.pop_front())
        buffer[size++] = model_.said.front();
      if (size != 0 || clock_.now() >= until_ns) return true;
      clock_.sleepUntil(std::min(until_ns, clock_.now() + kStep_ns));
    }
    return false;
  }
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) noexcept override {
    if (!there() || model_.deaf) return false;
    model_.hear(bytes);
    return true;
  }
  void lastWords(std::span<const std::uint8_t> bytes) noexcept override { (void)write(bytes); }

 private:
  [[nodiscard]] bool there() noexcept {
    model_.advance(clock_.now());
    return open_ && model_.plugged();
  }

  SerialModel& model_;
  hapticd::Clock& clock_;
  bool open_ = false;
};

}  // namespace haptic_emu
