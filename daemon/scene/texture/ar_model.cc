#include "daemon/scene/texture/ar_model.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace hapticd {
namespace {

constexpr std::size_t kGrid = 4096;  // Frequencies from 0 to half the new rate.
constexpr int kMostHalvings = 40;    // Of a step of that grid: a resonance is as narrow as isStable() lets it be,
constexpr int kAllHalvings = 10000;  // and takes some 150. Where poles lie so close that rounding is all, no more help.
constexpr double kFloor = 1e-9;      // White noise added, of the power: keeps the recursion away from zero.

/** The autocorrelation of what a model makes of noise of unit variance, of the part below half the wanted rate. */
class Spectrum {
 public:
  Spectrum(std::span<const double> a, double rate_hz, double wanted_hz)
      : a_(a), rate_hz_(rate_hz), wanted_hz_(wanted_hz) {}

  /** r[k] = integral of S(f) cos(2 pi f k / wanted), by trapezia; narrower ones where a resonance needs them. */
  std::array<double, kVibrationOrder + 1> integrate() {
    static const std::vector<double> kCosine = [] {
      std::vector<double> table(2 * kGrid);
      for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = std::cos(std::numbers::pi * static_cast<double>(i) / kGrid);
      return table;
    }();
    const double df = wanted_hz_ / 2 / kGrid, last_hz = std::min(wanted_hz_, rate_hz_) / 2;
    Place left = at(0);
    double width = 0;  // Of the trapezia that end at `left`, halved.
    for (std::size_t j = 0; left.f < last_hz; ++j) {
      const Place right = at(std::min(static_cast<double>(j + 1) * df, last_hz));
      const bool plain = areAlike(left, right);
      const double half = (right.f - left.f) / 2;
      if (!plain) integrate(left, right, kMostHalvings);
      const double s = density(left) * (width + (plain ? half : 0));
      for (std::size_t k = 0; k < r_.size(); ++k) r_[k] += s * kCosine[j * k % (2 * kGrid)];
      width = plain ? half : 0;
      left = right;
    }
    add(left, width);
    return r_;
  }

 private:
  /** A frequency and the model's denominator there. */
  struct Place {
    double f;
    std::complex<double> below;
  };

  [[nodiscard]] Place at(double f) const {
    const std::complex<double> z = std::polar(1.0, -2 * std::numbers::pi * f / rate_hz_);
    std::complex<double> sum = 0;
    for (std::size_t i = a_.size(); i > 0; --i) sum = (sum + a_[i - 1]) * z;
    return {f, 1.0 + sum};
  }
  /** Power per hertz, for both signs of f together. */
  [[nodiscard]] double density(const Place& place) const {
    return 2 / (rate_hz_ * std::max(std::norm(place.below), 1e-26));
  }
  /** Past a pole the denominator turns by half a turn, however near to the unit circle that lies. */
  static bool areAlike(const Place& a, const Place& b) {
    const std::complex<double> turned = b.below * std::conj(a.below);
    const double ratio = std::norm(b.below) / std::norm(a.below);
    return turned.real() > 0 && std::abs(turned.imag()) < 0.1 * turned.real() && ratio > 0.8 && ratio < 1.25;
  }
  void integrate(const Place& left, const Place& right, int halvings) {
    if (halvings == 0 || halvings_left_ == 0 || areAlike(left, right)) {
      const double half = (right.f - left.f) / 2;
      add(left, half);
      add(right, half);
      return;
    }
    --halvings_left_;
    const Place middle = at((left.f + right.f) / 2);
    integrate(left, middle, halvings - 1);
    integrate(middle, right, halvings - 1);
  }
  void add(const Place& place, double width) {
    const double s = density(place) * width, turn = 2 * std::numbers::pi * place.f / wanted_hz_;
    for (std::size_t k = 0; k < r_.size(); ++k) r_[k] += s * std::cos(turn * static_cast<double>(k));
  }

  std::span<const double> a_;
  double rate_hz_, wanted_hz_;
  int halvings_left_ = kAllHalvings;
  std::array<double, kVibrationOrder + 1> r_{};
};

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
  std::array<double, kVibrationOrder + 1> r = Spectrum(a, rate_hz, wanted_hz).integrate();
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
