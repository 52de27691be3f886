#include "daemon/scene/texture/ar_model.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace hapticd {
namespace {

constexpr std::size_t kGrid = 2048;  // Frequencies from 0 to half the new rate.
constexpr double kFloor = 1e-9;      // White noise added, of the power: keeps the recursion away from zero.

/** Power of the model at frequency f, per hertz, for both signs of f together, where its noise has unit variance. */
double density(std::span<const double> a, double rate_hz, double f) {
  if (f >= rate_hz / 2) return 0;
  const std::complex<double> z = std::polar(1.0, -2 * std::numbers::pi * f / rate_hz);
  std::complex<double> sum = 0;
  for (std::size_t i = a.size(); i > 0; --i) sum = (sum + a[i - 1]) * z;
  return 2 / (rate_hz * std::norm(1.0 + sum));
}

}  // namespace

bool isStable(std::span<const double> a) {
  std::vector<double> now(a.begin(), a.end());
  while (!now.empty()) {
    const double k = now.back();
    if (!(std::abs(k) < 1 - 1e-12)) return false;
    std::vector<double> less(now.size() - 1);
    for (std::size_t i = 0; i < less.size(); ++i) less[i] = (now[i] - k * now[less.size() - 1 - i]) / (1 - k * k);
    now = std::move(less);
  }
  return true;
}

LatticeModel resample(std::span<const double> a, double variance, double rate_hz, double wanted_hz) {
  // r[k] = integral of S(f) cos(2 pi f k / wanted) by the midpoint rule; cosines from one table.
  std::array<double, kVibrationOrder + 1> r{};
  static const std::vector<double> kCosine = [] {
    std::vector<double> table(4 * kGrid);
    for (std::size_t i = 0; i < table.size(); ++i)
      table[i] = std::cos(std::numbers::pi * static_cast<double>(i) / (2.0 * kGrid));
    return table;
  }();
  const double df = wanted_hz / 2 / kGrid;
  for (std::size_t j = 0; j < kGrid; ++j) {
    const double s = density(a, rate_hz, (static_cast<double>(j) + 0.5) * df) * df;
    for (std::size_t k = 0; k < r.size(); ++k) r[k] += s * kCosine[(2 * j + 1) * k % (4 * kGrid)];
  }
  LatticeModel out;
  out.power = variance * r[0];
  r[0] *= 1 + kFloor;
  std::array<double, kVibrationOrder> now{};
  double error = r[0];
  for (std::size_t m = 0; m < kVibrationOrder; ++m) {
    double sum = r[m + 1];
    for (std::size_t i = 0; i < m; ++i) sum += now[i] * r[m - i];
    const double k = -sum / error;
    out.reflection[m] = k;
    std::array<double, kVibrationOrder> next = now;
    for (std::size_t i = 0; i < m; ++i) next[i] = now[i] + k * now[m - 1 - i];
    next[m] = k;
    now = next;
    error *= 1 - k * k;
  }
  return out;
}

}  // namespace hapticd
