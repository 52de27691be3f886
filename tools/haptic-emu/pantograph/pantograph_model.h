/** @file
 * A two-motor pantograph, played from its bytes down to the grip.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/haptic-emu/hand.h"
#include "tools/haptic-emu/serial_model.h"

namespace haptic_emu {

/** Motors keep what they were last told. Frame of the hand: hapticd's, z unused, zero 0.07 m before the motors. */
class PantographModel final : public SerialModel {
 public:
  PantographModel();

  void advance(std::int64_t t_ns) override;
  void hear(std::span<const std::uint8_t> bytes) override;

  Hand hand;
  /** Arms straight out: the pose in which it wants to be set up. */
  void armsOut();
  [[nodiscard]] Vec3 force() const;
  [[nodiscard]] const std::array<double, 2>& torques() const { return torque_; }
  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] std::uint64_t orders() const { return orders_; }

 private:
  /** Motors' angles [rad] at p, by the law of cosines. */
  [[nodiscard]] static std::array<double, 2> angles(const Vec3& p);
  void answer();

  std::vector<std::uint8_t> heard_;
  std::array<double, 2> torque_{}, zero_{}, offset_deg_{}, counts_{13824, 13824};
  bool ready_ = false;
  std::int64_t stepped_ns_ = 0, answer_ns_ = -1;
  std::uint64_t orders_ = 0;
  Noise noise_{11};
};

}  // namespace haptic_emu
