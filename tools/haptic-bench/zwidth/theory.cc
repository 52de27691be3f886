#include "tools/haptic-bench/zwidth/theory.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace haptic_bench::zwidth {

double colgate(double device_damping, double damping, double tick_s) {
  return std::max(0.0, 2 * (device_damping - std::abs(damping)) / tick_s);
}

double colgateDelayed(double device_damping, double damping, double tick_s, std::uint32_t delay) {
  constexpr int kFrequencies = 2000;
  double most = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= kFrequencies; ++i) {
    const double angle = std::numbers::pi * i / kFrequencies;
    const std::complex<double> z = std::polar(1.0, angle);
    const std::complex<double> common =
        tick_s / 2 * (1.0 - 1.0 / z) * std::pow(z, -static_cast<double>(delay)) / (1 - std::cos(angle));
    const double of_stiffness = common.real();
    const double of_damping = (common * (1.0 - 1.0 / z)).real() / tick_s;
    const double left = device_damping - damping * of_damping;
    if (of_stiffness > 0) {
      most = std::min(most, left / of_stiffness);
    } else if (left < 0) {
      return 0;  // A stiffness that would help here is too much elsewhere.
    }
  }
  return std::max(0.0, most);
}

double frictionLimit(double friction, double step) {
  return step > 0 ? 2 * friction / step : std::numeric_limits<double>::infinity();
}

}  // namespace haptic_bench::zwidth
