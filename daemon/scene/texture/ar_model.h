/** @file
 * Autoregressive models: stability, and another sampling rate.
 */
#pragma once

#include <array>
#include <span>

#include "rt/scene/texture.h"

namespace hapticd {

/** All poles of 1 / (1 + a1 z^-1 + ...) lie inside the unit circle (step-down recursion: every |k| < 1). */
[[nodiscard]] bool isStable(std::span<const double> a);

/** What a lattice of fixed order needs. */
struct LatticeModel {
  double power = 0;  ///< Variance of the output.
  std::array<double, kVibrationOrder> reflection{};
};

/**
 * The model y[n] = e[n] - sum a y, e of that variance at rate_hz, as the servo at `wanted_hz` plays it: the part of
 * its spectrum below half the new rate, by autocorrelation and Levinson and Durbin's recursion, which gives a stable
 * model whatever the spectrum. Culbertson et al. (2014) resample for the same reason by other means. `a` is stable. A
 * model without noise is silent, and has the reflection coefficients of any other: towards it a texture fades, and
 * sounds as it did.
 */
[[nodiscard]] LatticeModel resample(std::span<const double> a, double variance, double rate_hz, double wanted_hz);

}  // namespace hapticd
