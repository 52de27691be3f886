/** @file
 * A played HID device that takes nothing any more.
 */
#pragma once

#include "rt/base/clock.h"
#include "tools/haptic-emu/in_process_hid.h"

namespace hapticd::test {

/** What is sent and asked for takes so long and is then refused, once it hangs: the kernel waits five seconds. */
class HidThatHangs final : public HidTransport {
 public:
  struct Hang {
    bool now = false;
    std::int64_t takes_ns = 0;
    int attempts = 0;
    bool asked_only = false;  ///< What is sent it takes.
  };
  HidThatHangs(haptic_emu::HidModel& model, ManualClock& clock, Hang& hang)
      : hid_(model, clock), clock_(clock), hang_(hang) {}
  Result<void> open() override { return hid_.open(); }
  void close() noexcept override { hid_.close(); }
  const std::vector<std::uint8_t>& descriptor() const noexcept override { return hid_.descriptor(); }
  std::int64_t now() const noexcept override { return hid_.now(); }
  HidResult read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept override {
    return hid_.read(buffer, size, until_ns);
  }
  HidResult write(std::span<const std::uint8_t> report) noexcept override {
    return hangs() ? refused() : hid_.write(report);
  }
  HidResult setFeature(std::span<const std::uint8_t> report) noexcept override {
    return hangs() ? refused() : hid_.setFeature(report);
  }
  HidResult getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept override {
    return hang_.now ? refused() : hid_.getFeature(buffer, size);
  }
  void lastWords(std::span<const std::uint8_t> report) noexcept override { hid_.lastWords(report); }

 private:
  [[nodiscard]] bool hangs() const noexcept { return hang_.now && !hang_.asked_only; }
  HidResult refused() noexcept {
    ++hang_.attempts;
    clock_.advance(hang_.takes_ns);
    return HidResult::kRefused;
  }

  haptic_emu::InProcessHid hid_;
  ManualClock& clock_;
  Hang& hang_;
};

}  // namespace hapticd::test
