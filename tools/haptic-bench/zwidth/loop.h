/** @file
 * What closes the loop: device, hand, rate and delay.
 */
#pragma once

#include <cstdint>
#include <string>

#include "drivers/sim/sim_parameters.h"

namespace haptic_bench::zwidth {

inline constexpr double kGap = 1e-3;  ///< From the hand at rest to the wall [m].

/** What of the device a sweep sets; the rest is as its URI says. */
struct Change {
  double rate_hz = 1000;
  std::uint32_t delay = 0;
  double step = -1;      ///< Of the encoder [m]; negative: as the URI says.
  double friction = -1;  ///< Dry [N]; negative: as the URI says.
};

/** One configuration of the sweep. */
struct Loop {
  hapticd::SimSetup device;
  double rate_hz = 1000;    ///< Of servo and device alike.
  std::uint32_t delay = 0;  ///< From a sample to its force, beyond the tick through which a force is held [ticks].
  double push = 4;          ///< With which the hand presses in the end [N].
  double force_slew = 1e6;  ///< Slew limit of the guard [N/s].
  bool passivity = false;   ///< The guard's controller.
};

/**
 * The loop of `uri` with a hand that waits for orders. Throws Failure as makeDevice, and for what is no sim://, has
 * no hand that presses, or does not reach the wall.
 */
[[nodiscard]] Loop makeLoop(const std::string& uri, const Change& change);

}  // namespace haptic_bench::zwidth
