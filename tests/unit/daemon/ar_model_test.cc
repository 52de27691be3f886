#include "daemon/scene/texture/ar_model.h"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>
#include <vector>

namespace hapticd {
namespace {

/** Coefficients of the polynomial with these poles (the conjugates added). */
std::vector<double> fromPoles(const std::vector<std::complex<double>>& poles) {
  std::vector<double> a{1};
  for (const auto& p : poles) {
    std::vector<double> next(a.size() + 2);
    for (std::size_t i = 0; i < a.size(); ++i) {
      next[i] += a[i];
      next[i + 1] -= 2 * p.real() * a[i];
      next[i + 2] += std::norm(p) * a[i];
    }
    a = next;
  }
  return {a.begin() + 1, a.end()};
}

/** Power per hertz of a direct-form model. */
double density(const std::vector<double>& a, double variance, double rate_hz, double f) {
  std::complex<double> sum = 1;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += a[i] * std::polar(1.0, -2 * std::numbers::pi * f / rate_hz * static_cast<double>(i + 1));
  return 2 * variance / rate_hz / std::norm(sum);
}

/** The direct form of a lattice and the variance of its noise. */
std::vector<double> direct(const LatticeModel& lattice, double& variance) {
  std::vector<double> a;
  variance = lattice.power;
  for (const double k : lattice.reflection) {
    std::vector<double> next(a.size() + 1);
    for (std::size_t i = 0; i < a.size(); ++i) next[i] = a[i] + k * a[a.size() - 1 - i];
    next.back() = k;
    a = next;
    variance *= 1 - k * k;
  }
  return a;
}

TEST(ArModel, StabilityIsWhereThePolesAre) {
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::complex<double>> poles;
    double most = 0;
    for (int k = 0; k < 1 + i % 4; ++k) {
      const double r = 0.6 + 0.5 * std::fmod(0.618 * i + 0.31 * k, 1.0);
      if (std::abs(r - 1) < 1e-3) continue;
      most = std::max(most, r);
      poles.push_back(std::polar(r, 0.1 + 2.9 * std::fmod(0.37 * i + 0.7 * k, 1.0)));
    }
    ASSERT_EQ(isStable(fromPoles(poles)), most < 1) << i;
  }
  EXPECT_TRUE(isStable(std::vector<double>{-0.999}));
  EXPECT_FALSE(isStable(std::vector<double>{-1.0}));
  EXPECT_FALSE(isStable(std::vector<double>{std::nan("")}));
}

TEST(ArModel, AtItsOwnRateItStaysItself) {
  const double a = -0.9, variance = 0.3;
  const LatticeModel lattice = resample(std::vector<double>{a}, variance, 1000, 1000);
  EXPECT_NEAR(lattice.power, variance / (1 - a * a), 1e-6);
  EXPECT_NEAR(lattice.reflection[0], a, 1e-6);
  for (std::size_t i = 1; i < kVibrationOrder; ++i) EXPECT_NEAR(lattice.reflection[i], 0, 1e-5);
}

/** What the servo can play of a recording at 10 kHz: two resonances, at 60 and 230 Hz, within 5 %. */
TEST(ArModel, TheSpectrumBelowHalfTheServosRateIsKept) {
  const auto pole = [](double hz, double r) { return std::polar(r, 2 * std::numbers::pi * hz / 10000); };
  const std::vector<double> a = fromPoles({pole(60, 0.985), pole(230, 0.98), pole(2000, 0.9)});
  const double variance = 1e-4;
  for (const double rate_hz : {1000.0, 2000.0, 4000.0}) {
    double noise = 0;
    const LatticeModel lattice = resample(a, variance, 10000, rate_hz);
    for (const double k : lattice.reflection) ASSERT_LT(std::abs(k), 1);
    const std::vector<double> played = direct(lattice, noise);
    double power = 0;
    for (double f = 0.05; f < rate_hz / 2; f += 0.1) power += 0.1 * density(a, variance, 10000, f);
    EXPECT_NEAR(lattice.power / power, 1, 1e-3) << rate_hz;
    for (const double f : {20.0, 60.0, 100.0, 230.0, 300.0}) {
      EXPECT_NEAR(density(played, noise, rate_hz, f) / density(a, variance, 10000, f), 1, 0.05)
          << f << " of " << rate_hz;
    }
  }
}

/** Of the whole model, by its reflection coefficients. */
double powerOf(std::vector<double> a) {
  double power = 1;
  for (; !a.empty();) {
    const double k = a.back();
    power /= 1 - k * k;
    std::vector<double> less(a.size() - 1);
    for (std::size_t i = 0; i < less.size(); ++i) less[i] = (a[i] - k * a[less.size() - 1 - i]) / (1 - k * k);
    a = std::move(less);
  }
  return power;
}

/** However narrow, and wherever it lies between the frequencies that are looked at. */
TEST(ArModel, ANarrowResonanceIsAsLoudAsItWas) {
  for (const double hz : {60.0, 60.06, 125.0 / 1.024, 230.11, 400.03}) {
    for (const double r : {0.999, 0.9999, 0.99999, 0.999999, 1 - 1e-8}) {
      const std::vector<double> a = fromPoles({std::polar(r, 2 * std::numbers::pi * hz / 10000)});
      for (const double rate_hz : {1000.0, 4000.0}) {
        const LatticeModel lattice = resample(a, 3, 10000, rate_hz);
        EXPECT_NEAR(lattice.power / (3 * powerOf(a)), 1, 0.01) << hz << " Hz, " << r << " at " << rate_hz;
        EXPECT_NEAR(-lattice.reflection[0], std::cos(2 * std::numbers::pi * hz / rate_hz), 0.01);
        for (const double k : lattice.reflection) ASSERT_LT(std::abs(k), 1);
      }
    }
  }
}

TEST(ArModel, PolesThatRoundingRunsTogetherEndInANumber) {
  const std::vector<double> a = fromPoles(std::vector<std::complex<double>>(16, std::polar(0.97, 0.02)));
  for (const double rate_hz : {1000.0, 4000.0}) {
    const LatticeModel lattice = resample(a, 1, 10000, rate_hz);
    EXPECT_TRUE(std::isfinite(lattice.power));
    for (const double k : lattice.reflection) ASSERT_LT(std::abs(k), 1);
  }
}

/** The same two resonances in a recording at 1 kHz, of which the servo makes more samples than it has. */
TEST(ArModel, ASlowerRecordingKeepsItsPowerAndIsBlurred) {
  const auto pole = [](double hz, double r) { return std::polar(r, 2 * std::numbers::pi * hz / 1000); };
  const std::vector<double> a = fromPoles({pole(60, 0.86), pole(230, 0.82)});
  for (const double rate_hz : {2000.0, 4000.0}) {
    double noise = 0;
    const LatticeModel lattice = resample(a, 1, 1000, rate_hz);
    const std::vector<double> played = direct(lattice, noise);
    const auto power = [](const std::vector<double>& model, double variance, double rate, double from, double to) {
      double sum = 0;
      for (double f = from; f < to; f += 0.1) sum += 0.1 * density(model, variance, rate, f);
      return sum;
    };
    const double whole = power(a, 1, 1000, 0.05, 500);
    EXPECT_NEAR(lattice.power / whole, 1, 1e-3) << rate_hz;
    EXPECT_LT(power(played, noise, rate_hz, 550, rate_hz / 2) / whole, 1e-4) << rate_hz;
    const double third = std::cbrt(2.0);
    for (double f = 20; f * third < 500; f *= third) {
      const double off = power(played, noise, rate_hz, f, f * third) / power(a, 1, 1000, f, f * third);
      EXPECT_NEAR(off, 1, 0.6) << f << " of " << rate_hz;
    }
  }
}

TEST(ArModel, FasterThanTheRecordingAddsNothing) {
  const std::vector<double> a{-0.5};
  const LatticeModel lattice = resample(a, 1, 500, 4000);
  EXPECT_NEAR(lattice.power, 1 / (1 - 0.25), 1e-3);
  for (const double k : lattice.reflection) EXPECT_LT(std::abs(k), 1);
}

/** As those of the Haptic Texture Toolkit at speed or force zero: between them and the others it fades, and no more. */
TEST(ArModel, ASilentModelKeepsItsColour) {
  const std::vector<double> a = fromPoles({std::polar(0.99, 0.04), std::polar(0.9, 0.3)});
  for (const double rate_hz : {1000.0, 4000.0}) {
    const LatticeModel silent = resample(a, 0, 10000, rate_hz), loud = resample(a, 7, 10000, rate_hz);
    EXPECT_EQ(silent.power, 0);
    EXPECT_EQ(silent.reflection, loud.reflection);
    EXPECT_LT(loud.reflection[0], -0.5);
    EXPECT_NEAR(loud.power, 7 * resample(a, 1, 10000, rate_hz).power, 1e-12 * loud.power);
  }
}

}  // namespace
}  // namespace hapticd
