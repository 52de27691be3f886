/** @file
 * The sample device: three straight axes, a reading a millisecond, a watchdog of 100 ms. Nothing is for sale; it shows
 * what a driver and a played device look like.
 */
#pragma once

#include <cstdint>

#include "tools/haptic-emu/hand.h"
#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

class SampleModel final : public UsbModel {
 public:
  static constexpr std::int64_t kWatchdog_ns = 100'000'000;

  SampleModel() : hand(HandParameters{}) {}

  /** The identifiers are those that pid.codes keeps for tests. */
  [[nodiscard]] UsbIdentity identity() const override {
    return {0x1209, 0x0001, 0x0100, "hapticd", "sample device", "sample"};
  }
  void advance(std::int64_t t_ns) override;
  [[nodiscard]] bool control(const hapticd::UsbControl&) override { return false; }
  void out(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> in(std::size_t most) override;

  Hand hand;  ///< Axes: right, up, toward the operator.
  std::uint8_t buttons = 0;
  /** What the motors push with now [N]. */
  [[nodiscard]] const Vec3& force() const { return force_; }

 private:
  Vec3 force_ = Vec3::Zero();
  std::int64_t ordered_ns_ = 0;
  std::int64_t said_ms_ = -1;
  std::uint8_t number_ = 0;
  Noise noise_{2};
};

}  // namespace haptic_emu
