/** @file
 * Somebody at a played Falcon: homes it when the red light asks, then presses to and fro.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/haptic-emu/falcon/falcon_model.h"

namespace haptic_emu {

struct FalconHabits {
  bool homes = true;
  double press = 0.01;  ///< Toward the base, from the middle [m].
  double period_s = 2;
};

/** Moves the hand of `model`, which outlives it. */
class FalconUser {
 public:
  FalconUser(FalconModel& model, const FalconHabits& habits) : model_(model), habits_(habits) {}

  /** What the user wants at that time. */
  void act(std::int64_t now_ns) {
    constexpr double kMiddle = 0.125, kOut = FalconModel::kFarOut + 0.005;
    most_ = std::max(most_, model_.force().norm());
    const bool asked = (model_.lights() & 1) != 0 && !model_.homed();
    if (!asked) homing_since_ns_ = -1;
    if (asked && habits_.homes) {
      if (homing_since_ns_ < 0) homing_since_ns_ = now_ns;
      const bool pulls = now_ns - homing_since_ns_ < 700'000'000;
      model_.hand.want({0, 0, pulls ? kOut : kMiddle});
      return;
    }
    const double turn = static_cast<double>(now_ns) * 1e-9 / habits_.period_s * 6.283185307179586;
    model_.hand.want({0, 0, kMiddle - (model_.homed() ? habits_.press * 0.5 * (1 - std::cos(turn)) : 0)});
  }

  /** The strongest force since the last call [N]. */
  [[nodiscard]] double takeMost() { return std::exchange(most_, 0); }

 private:
  FalconModel& model_;
  FalconHabits habits_;
  std::int64_t homing_since_ns_ = -1;
  double most_ = 0;
};

}  // namespace haptic_emu
