/** @file
 * A force-feedback joystick, played report by report: effects with their time and pool, actuators, the safety switch,
 * a stick with a hand on it.
 */
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>

#include "tools/haptic-emu/hand.h"
#include "tools/haptic-emu/hid_model.h"
#include "tools/haptic-emu/hidpid/pid_descriptor.h"

namespace haptic_emu {

/** Its Y (toward the user) is hapticd's x, its X (to the right) hapticd's y. */
class PidModel final : public HidModel {
 public:
  static constexpr double kFullForce = 4;  ///< [N]
  static constexpr double kTravel = 0.05;  ///< From the middle to an end [m].

  explicit PidModel(const PidVariant& variant = {});

  [[nodiscard]] const Bytes& descriptor() const override { return descriptor_; }
  void advance(std::int64_t t_ns) override;
  [[nodiscard]] bool out(std::span<const std::uint8_t> report) override;
  [[nodiscard]] std::optional<Bytes> in() override;
  [[nodiscard]] bool setFeature(std::span<const std::uint8_t> report) override;
  [[nodiscard]] std::optional<Bytes> getFeature(std::uint8_t id) override;

  Hand hand;
  std::uint8_t buttons = 0;
  /** The user's hand is on, or off, the stick's sensor. */
  void holdSafetySwitch(bool held);
  void power(bool on);

  [[nodiscard]] Vec3 force() const;  ///< [N]
  [[nodiscard]] bool actuatorsOn() const { return actuators_; }
  [[nodiscard]] std::size_t effects() const { return effects_.size(); }
  /** Running now, by their type's number in Set Effect (1 constant, 8 spring, 9 damper). */
  [[nodiscard]] int running(int type) const;
  [[nodiscard]] std::uint64_t constants() const { return constants_; }  ///< Set Constant reports taken.
  [[nodiscard]] std::int64_t longestDuration_ms() const { return longest_ms_; }
  int refused = 0;     ///< Report that it stalls, by its ID; 0: none.
  int busy_polls = 2;  ///< How often Block Load says "not yet" before it says where.

 private:
  struct PlayedEffect {
    int type = 0, axes = 0;
    int trigger = 0;  ///< Button that starts it, 1 the first; 0: none.
    std::int64_t duration_ms = 0, ends_ns = -1;
    double degrees = 0, gain = 0, magnitude = 0;
    std::array<double, 2> centre{}, coefficient{}, saturation{1, 1};
  };

  [[nodiscard]] bool setEffect(std::span<const std::uint8_t> d);
  [[nodiscard]] bool setCondition(std::span<const std::uint8_t> d);
  void control(int order);
  void pullTriggers();
  void tellState();
  void forget();

  PidVariant variant_;
  Bytes descriptor_;
  std::map<int, PlayedEffect> effects_;
  int new_block_ = 0, polls_left_ = 0, load_status_ = 3;
  std::uint8_t sent_buttons_ = 0, held_buttons_ = 0;
  bool actuators_ = false, safety_ = true, power_ = true;
  Vec3 last_position_ = Vec3::Zero(), velocity_ = Vec3::Zero();
  std::int64_t stepped_ns_ = 0, next_ns_ = 0, longest_ms_ = 0;
  std::uint64_t constants_ = 0;
  std::deque<Bytes> queue_;
};

}  // namespace haptic_emu
