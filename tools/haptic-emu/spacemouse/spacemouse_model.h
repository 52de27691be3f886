/** @file
 * A SpaceMouse, played report by report: the cap's deflections as the device takes turns to tell them, its buttons and
 * its light.
 */
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "tools/haptic-emu/hid_model.h"

namespace haptic_emu {

/** old: translation in report 1, rotation in report 2, every 8 ms the other one. New: both in report 1, every 8 ms. */
class SpaceMouseModel final : public HidModel {
 public:
  static constexpr std::int64_t kPeriod_ns = 8'000'000;

  explicit SpaceMouseModel(bool new_layout);

  [[nodiscard]] const Bytes& descriptor() const override { return descriptor_; }
  void advance(std::int64_t t_ns) override;
  [[nodiscard]] bool out(std::span<const std::uint8_t> report) override;
  [[nodiscard]] std::optional<Bytes> in() override;

  /** Deflection in the device's axes (x right, y toward the user, z down), counts up to 350. */
  void push(const std::array<int, 6>& axes) { axes_ = axes; }
  void press(std::uint32_t buttons);
  void tellBattery(std::uint8_t percent) { queue_.push_back({0x17, percent, 0}); }
  [[nodiscard]] bool light() const { return light_; }

 private:
  void say();

  bool new_layout_;
  Bytes descriptor_;
  std::array<int, 6> axes_{};
  int zeros_left_ = 0;  ///< How often it will still say that the cap is let go.
  bool rotation_next_ = false, light_ = false;
  std::int64_t next_ns_ = 0;
  std::deque<Bytes> queue_;
};

}  // namespace haptic_emu
