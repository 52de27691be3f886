/** @file
 * One trial of the closed loop: the simulated device with its hand taps a virtual wall and goes on pressing, while the
 * cycle renders it, stepped by hand exactly as the servo steps it.
 */
#pragma once

#include "tools/haptic-bench/zwidth/loop.h"

namespace haptic_bench::zwidth {

inline constexpr double kTrial_s = 3;  ///< From the tap to the end, but for what is heavy; see trialLength().
inline constexpr double kWindow_s =
    0.5;  ///< Of the early look, a sixth of the trial after the tap, and of the late, at its end.
inline constexpr double kDecay = 0.9;   ///< Late over early amplitude that still counts as decay.
inline constexpr double kSteps = 8;     ///< Encoder steps, peak to peak, that hunting may take.
inline constexpr double kStill = 1e-6;  ///< Peak to peak [m] that may be left however fine the encoder.
inline constexpr double kBuzz_hz = 30;  ///< Hands do not move faster by will: above it is vibration.

/** Virtual wall. */
struct Wall {
  double stiffness = 0;  ///< [N/m]
  double damping = 0;    ///< Along the normal [N s/m].
};

/**
 * What came of it. Amplitudes are peak to peak, of the true place of the hand and not of its reading.
 *
 * Stable means: no fault has latched, contact is held through the late window, and in it the oscillation has either
 * decayed to kDecay of the early one, or is at most kSteps encoder steps (or kStill). Decay alone cannot be asked for
 * where position comes in steps: the force then has no value that balances the hand, and every wall hunts for it
 * (Diolaiti et al. 2006); the velocity estimate moreover takes up to two steps for noise. docs/stability.md says more.
 */
struct Tap {
  bool stable = false;
  double early_m = 0, late_m = 0;
  double displayed = 0;  ///< Mean force over mean depth read, in the late window [N/m].
  double buzz = 0;       ///< Mean square of the force above kBuzz_hz in the late window [N^2].
};

/**
 * Fifty times mass over damping, of device and hand, but 3 s at least and 30 s at most: the bounces of the tap are over
 * then even near the limit, where a heavy hand on a light damper takes long, and their decay is seen [s].
 */
[[nodiscard]] double trialLength(const Loop& loop);

[[nodiscard]] Tap tap(const Loop& loop, const Wall& wall);

}  // namespace haptic_bench::zwidth
