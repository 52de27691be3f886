#include "tools/haptic-bench/zwidth/buzz.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace haptic_bench::zwidth {

double powerAbove(const std::vector<double>& signal, double rate_hz, double above_hz) {
  const std::size_t n = signal.size();
  if (n < 8) return 0;
  const double count = static_cast<double>(n);
  const double mean = std::accumulate(signal.begin(), signal.end(), 0.0) / count;
  std::vector<double> windowed(n);
  double weight = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / count);
    windowed[i] = w * (signal[i] - mean);
    weight += w * w;
  }
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, windowed);
  double power = 0;
  for (std::size_t bin = 1; 2 * bin <= n; ++bin) {
    if (static_cast<double>(bin) * rate_hz / count <= above_hz) continue;
    power += (2 * bin == n ? 1 : 2) * std::norm(spectrum[bin]);
  }
  return power / (count * weight);
}

}  // namespace haptic_bench::zwidth
