/** @file
 * A Novint Falcon, played from its USB packets down to the grip: the serial chip with its latency timer, the loader,
 * the firmware (any file will do) and the mechanics.
 */
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "tools/haptic-emu/falcon/falcon_arm.h"
#include "tools/haptic-emu/hand.h"
#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

/**
 * Starts as after power-up: no firmware, nothing homed, encoders at an offset. Homing asks for the grip far out and
 * then in again while the host requests it. Motors keep what they were last told, for nothing is known of a watchdog.
 */
class FalconModel final : public UsbModel {
 public:
  static constexpr double kFarOut = 0.168, kInAgain = 0.150;  ///< z at which homing sees the ends [m].
  static constexpr std::size_t kLeastFirmware = 1024;

  FalconModel();

  [[nodiscard]] UsbIdentity identity() const override {
    return {0x0403, 0xcb48, 0x0600, "Novint", "FALCON HAPTIC", "EMU00001"};
  }
  void advance(std::int64_t t_ns) override;
  [[nodiscard]] bool control(const hapticd::UsbControl& request) override;
  void out(std::span<const std::uint8_t> bytes) override;
  [[nodiscard]] std::optional<std::vector<std::uint8_t>> in(std::size_t most) override;

  // What stands behind, for tests and for those who play the user. Frame of the device.
  Hand hand;
  std::uint8_t buttons = 0;
  std::int64_t loader_thinks_ns = 0;  ///< Before it answers, until its firmware runs.
  /** Firmware runs and all is homed, as after a first session that ended well. */
  void warmUp();
  /** As when its firmware starts anew by itself. */
  void loseHoming() { homed_ = 0, was_far_out_ = false; }
  [[nodiscard]] bool running() const { return mode_ == Mode::kRunning; }
  [[nodiscard]] bool homed() const { return homed_ == 7; }
  [[nodiscard]] const std::array<std::int16_t, 3>& motors() const { return motors_; }
  /** By the motors now [N]. */
  [[nodiscard]] Vec3 force() const { return falconForce(hand.position(), motors_); }
  [[nodiscard]] std::uint8_t lights() const { return lights_; }  ///< As in byte 13 of an order.
  [[nodiscard]] std::uint64_t orders() const { return orders_; }
  [[nodiscard]] const std::vector<std::uint8_t>& firmware() const { return firmware_; }
  /** How often an upload was begun. */
  [[nodiscard]] int uploads() const { return uploads_; }
  /** The most any motor was told while not all was homed. */
  [[nodiscard]] int mostUnhomed() const { return most_unhomed_; }

 private:
  enum class Mode : std::uint8_t { kWaiting, kGreeted, kLoading, kRunning };

  void powerUp();
  void take(std::uint8_t byte);
  void order();
  void say(std::span<const std::uint8_t> bytes);
  void reply();
  void home();

  Mode mode_ = Mode::kWaiting;
  std::uint16_t divisor_ = 0x4138;
  std::int64_t latency_ns_ = 16'000'000;
  bool dtr_ = false;
  std::vector<std::uint8_t> heard_, firmware_;
  struct Said {
    std::int64_t at_ns;
    std::uint8_t byte;
  };
  std::deque<Said> said_;
  std::int64_t line_free_ns_ = 0;
  std::int64_t last_in_ns_ = 0;
  bool was_plugged_ = true;

  std::array<std::int16_t, 3> motors_{};
  std::uint8_t lights_ = 0;
  std::uint8_t homed_ = 0;
  bool was_far_out_ = false;
  std::uint64_t orders_ = 0;
  int most_unhomed_ = 0;
  int uploads_ = 0;
  Noise noise_{1};
};

}  // namespace haptic_emu
