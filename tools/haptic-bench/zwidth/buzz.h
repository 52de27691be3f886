/** @file
 * How much a signal vibrates.
 */
#pragma once

#include <vector>

namespace haptic_bench::zwidth {

/**
 * Mean square of the part of `signal` above `above_hz`: periodogram of the signal without its mean under a Hann window,
 * summed over the bins above, scaled so that a steady sine of amplitude a gives a^2 / 2 (Heinzel, Ruediger, Schilling,
 * Spectrum and spectral density estimation by the DFT, 2002). Zero for fewer than 8 samples.
 */
[[nodiscard]] double powerAbove(const std::vector<double>& signal, double rate_hz, double above_hz);

}  // namespace haptic_bench::zwidth
