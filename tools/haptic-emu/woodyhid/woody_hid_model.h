/** @file
 * A WoodenHaptics or Polhem, played from its reports down to the tip: the firmware with its turns, its watchdog and its
 * calibration button, the amplifiers, and the arm.
 */
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "tools/haptic-emu/hand.h"
#include "tools/haptic-emu/hid_model.h"
#include "tools/haptic-emu/woodyhid/woody_hid_arm.h"

namespace haptic_emu {

/**
 * After power-up the counters are 0 wherever the arm is. The firmware speaks once a millisecond, and after each word
 * waits until it is spoken to. When it is found, it waits already. Once it was spoken to twice for a word it is one
 * order behind (`behind`): the next word goes out before it obeys. Of orders that wait it obeys the newest alone.
 */
class WoodyHidModel final : public HidModel {
 public:
  static constexpr std::int64_t kPeriod_ns = 1'000'000;
  static constexpr std::int64_t kWatchdog_ns = 500'000'000;  ///< Silence that cuts the amplifiers.

  /** `report_bytes`: 64 of a Teensy, 14 of the first boards. */
  explicit WoodyHidModel(WoodyKind kind, std::uint8_t report_bytes = 64);

  [[nodiscard]] const Bytes& descriptor() const override { return descriptor_; }
  void advance(std::int64_t t_ns) override;
  [[nodiscard]] bool out(std::span<const std::uint8_t> report) override;
  [[nodiscard]] std::optional<Bytes> in() override;

  Hand hand;            ///< Frame of hapticd.
  bool button = false;  ///< Of the stylus.
  std::array<std::int16_t, 3> gimbal{};
  bool behind = false;
  int deaf_to_counters = 0;  ///< So many orders to set counters are lost, as when another comes at once.
  int refuses = 0;           ///< So many reports are stalled.
  /** The button on the electronics goes down. */
  void pressCalibration() { pressed_ = true; }

  [[nodiscard]] bool amplifiersOn() const { return amplifiers_; }
  [[nodiscard]] Vec3 force() const;
  [[nodiscard]] std::uint64_t heard() const { return heard_; }  ///< Reports that came.
  [[nodiscard]] std::uint64_t said() const { return said_; }    ///< Reports that went.
  [[nodiscard]] std::size_t longestQueue() const { return longest_; }
  [[nodiscard]] bool pressed() const { return pressed_; }

 private:
  void say();
  void obey(std::span<const std::uint8_t> report);
  [[nodiscard]] std::array<std::int16_t, 6> counters() const;

  WoodyKind kind_;
  std::uint8_t report_bytes_;
  Bytes descriptor_;
  std::array<double, 6> zero_{};  ///< What is taken off the exact counts.
  std::array<std::int16_t, 3> current_mA_{};
  bool amplifiers_ = false, pressed_ = false, waiting_ = true, powered_ = false;
  std::int64_t heard_ns_ = 0, next_ns_ = 0, stepped_ns_ = 0;
  std::deque<Bytes> queue_;
  Bytes waits_;  ///< An order not obeyed yet.
  std::uint64_t heard_ = 0, said_ = 0;
  std::size_t longest_ = 0;
  Noise noise_{7};
};

}  // namespace haptic_emu
