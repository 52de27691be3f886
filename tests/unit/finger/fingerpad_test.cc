// The fingerpad models of the thesis against numerical quadrature of its integrals, and its fits against fits.
#include "rt/finger/fingerpad.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace hapticd {
namespace {

constexpr double kPi = 3.141592653589793;
using Constants = FingertipConstants;

/** int from 0 to a of f, by Simpson's rule in r = a sin(t): a pressure may end with a vertical slope. */
double integral(double a, const std::function<double(double)>& f) {
  constexpr int kSteps = 2000;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = kPi / 2 * i / kSteps, weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * f(a * std::sin(t)) * a * std::cos(t);
  }
  return sum * kPi / 2 / kSteps / 3;
}

/** M / (mu P) of a pressure over a circle: eq. 2.1 and 2.3. */
double armOf(double a, const std::function<double(double)>& p) {
  return integral(a, [&](double r) { return p(r) * r * r; }) / integral(a, [&](double r) { return p(r) * r; });
}

/** y = p1 x^p2 nearest to the points, by Gauss and Newton. */
struct PowerLaw {
  double gain, power;
};
PowerLaw fit(const std::vector<double>& x, const std::vector<double>& y, PowerLaw law) {
  for (int round = 0; round < 200; ++round) {
    double aa = 0, ab = 0, bb = 0, ar = 0, br = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double a = std::pow(x[i], law.power), b = law.gain * a * std::log(x[i]), r = y[i] - law.gain * a;
      aa += a * a;
      ab += a * b;
      bb += b * b;
      ar += a * r;
      br += b * r;
    }
    const double det = aa * bb - ab * ab;
    law.gain += (bb * ar - ab * br) / det;
    law.power += (aa * br - ab * ar) / det;
  }
  return law;
}

/** Eq. 2.5 [m -> N]. */
double forceAt(double depth) {
  return Constants::kStiffness / Constants::kHardening * std::expm1(Constants::kHardening * depth);
}

TEST(Fingerpad, ArmsAreThoseOfTheirPressures) {
  for (const double force : {1e-3, 0.1, 1.0, 3.0, 6.5}) {
    for (const PadLaw law : {PadLaw::kHertz, PadLaw::kModifiedHertz}) {
      const double a = contactRadius({law}, force);
      ASSERT_GT(a, 0);
      const double arm = armOf(a, [&](double r) { return std::sqrt(std::max(0.0, 1 - r * r / (a * a))); });
      EXPECT_NEAR(momentArm({law}, force), arm, 1e-6 * arm);
    }
    const double R = Constants::kRadius, a = contactRadius({PadLaw::kFilledMembrane}, force);
    EXPECT_NEAR(momentArm({PadLaw::kFilledMembrane}, force), armOf(a, [](double) { return 1.0; }), 1e-6 * a);
    const double depth = indentationOf(force);
    EXPECT_NEAR(forceAt(depth), force, 1e-12 * force);
    EXPECT_NEAR((R - depth) * (R - depth) + a * a, R * R, 1e-12 * R * R) << "eq. 2.17";
    const double arm = armOf(a, [&](double r) { return std::sqrt(R * R - r * r) - R + depth; });
    EXPECT_NEAR(momentArm({PadLaw::kViscousSphere}, force), arm, 1e-6 * arm) << force;
  }
}

/** Eq. 2.20 as printed, with phi = asin(a / R), is the same but for the digits it loses where little is pressed. */
TEST(Fingerpad, TheViscousSphereIsThePrintedOne) {
  const double R = Constants::kRadius;
  for (const double force : {0.05, 0.5, 2.0, 6.5}) {
    const double d = indentationOf(force), a = std::sqrt(R * R - (R - d) * (R - d)), phi = std::asin(a / R);
    const double M = kPi * ((R - d) * a * (R * R / 4 - 2.0 / 3 * a * a) - a / 2 * std::pow(R * R - a * a, 1.5) +
                            std::pow(R, 4) / 4 * phi);
    const double P = kPi / 3 * d * d * (3 * R - d);
    EXPECT_NEAR(momentArm({PadLaw::kViscousSphere}, force), M / P, 1e-9 * R) << force;
  }
}

/** As the finger begins to press, where the printed one has no digits left unless it has more to begin with. */
TEST(Fingerpad, TheViscousSphereLosesNoDigitsWhereItHardlyTouches) {
  const long double R = Constants::kRadius;
  for (const long double aim : {0.02L, 0.05L, 0.08L, 0.0999L, 0.1001L, 0.2L}) {
    const double force = forceAt(static_cast<double>(R * (1 - std::cos(aim))));
    const long double d = indentationOf(force), a = std::sqrt(d * (2 * R - d)), phi = std::asin(a / R), s = a / R;
    const long double bracket = (phi - s * std::sqrt(1 - s * s) * (1 + 2 * s * s / 3)) / 4;
    const long double arm = R * R * R * R * bracket / (d * d * (3 * R - d) / 3);
    EXPECT_NEAR(momentArm({PadLaw::kViscousSphere}, force) / static_cast<double>(arm), 1, 1e-10) << force;
  }
}

TEST(Fingerpad, HertzsCircleIsThatOfItsBall) {
  for (const double radius : {2e-3, 5.8e-3, 20e-3}) {
    for (const double force : {0.01, 0.1, 1.0}) {
      const double hertz = contactRadius({PadLaw::kHertz, radius}, force);
      EXPECT_NEAR(4 * Constants::kModulus * std::pow(hertz, 3) / (3 * radius), force, 1e-12) << "eq. 2.12";
      const double a = contactRadius({PadLaw::kModifiedHertz, radius}, force), depth_mm = 1e3 * a * a / radius;
      EXPECT_NEAR(Constants::kPowerGain * std::pow(depth_mm, Constants::kPower), force, 1e-12) << "eq. 2.6 and 2.7";
    }
  }
}

TEST(Fingerpad, HertzGoesWithTheForceToTheFourThirds) {
  const Fingerpad pad{PadLaw::kHertz};
  EXPECT_NEAR(2 * momentArm(pad, 2) / momentArm(pad, 1), std::pow(2, 4.0 / 3), 1e-12);
}

/** The modified one by 1 + 1 / (2 p2): 1.1433 (eq. 2.16). */
TEST(Fingerpad, ModifiedHertzHasThePrintedExponent) {
  const Fingerpad pad{PadLaw::kModifiedHertz};
  EXPECT_NEAR(std::log2(2 * momentArm(pad, 2) / momentArm(pad, 1)), 1.1433, 5e-5);
}

/** Eq. 2.6 is the fit of 2.5 up to 6.5 N, and not to 2 N, as printed; 2.21 is the viscous sphere's over the same. */
TEST(Fingerpad, ThePrintedFitsAreFits) {
  std::vector<double> depth_mm, force, moment;
  const double deepest = indentationOf(6.5);
  for (int i = 1; i <= 2000; ++i) {
    const double depth = deepest * i / 2000;
    depth_mm.push_back(depth * 1e3);
    force.push_back(forceAt(depth));
    moment.push_back(force.back() * momentArm({PadLaw::kViscousSphere}, force.back()) * 1e3);
  }
  const PowerLaw indentation = fit(depth_mm, force, {1, 3});
  EXPECT_NEAR(indentation.gain, Constants::kPowerGain, 1e-3);
  EXPECT_NEAR(indentation.power, Constants::kPower, 3e-3);
  EXPECT_NEAR(fit(force, moment, {1, 1}).power, 1.1289, 5e-3);
}

TEST(Fingerpad, APointAndWhatIsNotPressedBearNothing) {
  for (const double force : {0.0, -1.0, std::nan("")}) {
    EXPECT_EQ(indentationOf(force), 0);
    for (std::uint32_t law = 0; law <= 5; ++law) {
      EXPECT_EQ(momentArm({static_cast<PadLaw>(law)}, force), 0);
      EXPECT_EQ(contactRadius({static_cast<PadLaw>(law)}, force), 0) << law << " at " << force;
    }
  }
  for (const PadLaw law : {PadLaw::kNone, PadLaw::kLinear}) EXPECT_EQ(contactRadius({law}, 1), 0);
  EXPECT_EQ(momentArm({PadLaw::kNone}, 1), 0);
  EXPECT_EQ(momentArm({PadLaw::kLinear}, 1), Constants::kArm);
  for (std::uint32_t law = 2; law <= 5; ++law) {
    const Fingerpad pad{static_cast<PadLaw>(law)};
    EXPECT_LE(momentArm(pad, 1e9), pad.radius) << law;
    EXPECT_TRUE(std::isfinite(momentArm(pad, 1e300))) << law;
    EXPECT_LE(momentArm(pad, 5e-324), pad.radius) << law;
    double last = 0;
    for (double force = 5e-324; force < 100; force *= force < 1e-12 ? 1e5 : 1.1) {
      EXPECT_GE(momentArm(pad, force), last) << law << " at " << force;
      last = momentArm(pad, force);
    }
  }
}

}  // namespace
}  // namespace hapticd
