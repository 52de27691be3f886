#include "rt/finger/fingerpad.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

using Constants = FingertipConstants;

constexpr double kPi = 3.141592653589793;
constexpr double kHertzArm = 3 * kPi / 16;  ///< Of a, for the ellipse of pressure of eq. 2.8: eq. 2.11.
constexpr double kUniformArm = 2.0 / 3;     ///< Of a, for the same pressure everywhere: eq. 2.24.
constexpr double kShallow = 0.1;            ///< Below this angle the series is the more exact [rad].

/** Of a ball that is cut by a plane at that depth: eq. 2.17. */
double cut(double radius, double depth) HD_RT {
  const double d = std::min(depth, radius);
  return std::sqrt(d * (2 * radius - d));
}

/** int from 0 to phi of sin^4, over phi^4: which is itself lost where phi is 1e-81. */
double sineToTheFourth(double phi) HD_RT {
  const double x = phi * phi;
  if (phi < kShallow) return phi * (1.0 / 5 + x * (-2.0 / 21 + x * (1.0 / 45 - x * 34.0 / 10395)));
  return (12 * phi - 8 * std::sin(2 * phi) + std::sin(4 * phi)) / (32 * x * x);
}

/**
 * Eq. 2.20 over 2.19, where k has gone. With sin(phi) = a / R and delta = R (1 - cos(phi)) the bracket of 2.20 is
 * R^4 (phi - s c (1 + 2 s^2 / 3)) / 4, whose derivative is 2/3 R^4 s^4: so it is R^4 2/3 int sin^4, which loses no
 * digits where the finger hardly touches.
 */
double viscousSphereArm(double radius, double force) HD_RT {
  const double depth = std::min(indentationOf(force), radius);
  if (!(depth > 0)) return 0;
  const double phi = 2 * std::asin(std::sqrt(depth / (2 * radius)));
  const double ratio = radius * phi / depth * phi;
  return 2 * radius * radius * ratio * ratio * sineToTheFourth(phi) / (3 * radius - depth);
}

}  // namespace

double indentationOf(double force) HD_RT {
  return force > 0 ? std::log1p(force * Constants::kHardening / Constants::kStiffness) / Constants::kHardening : 0;
}

double contactRadius(const Fingerpad& pad, double force) HD_RT {
  const double R = pad.radius;
  if (!(force > 0)) return 0;
  constexpr double kMillimetre = 1e-3;
  switch (pad.law) {
    case PadLaw::kNone:
    case PadLaw::kLinear:
      return 0;
    case PadLaw::kHertz:  // Eq. 2.12.
      return std::min(R, std::cbrt(3 * force * R / (4 * Constants::kModulus)));
    case PadLaw::kModifiedHertz:  // Eq. 2.7 with 2.6: eq. 2.15, inverted.
      return std::min(R, std::sqrt(R * kMillimetre * std::pow(force / Constants::kPowerGain, 1 / Constants::kPower)));
    case PadLaw::kViscousSphere:
    case PadLaw::kFilledMembrane:
      return cut(R, indentationOf(force));
  }
  return 0;
}

double momentArm(const Fingerpad& pad, double force) HD_RT {
  if (!(force > 0)) return 0;
  switch (pad.law) {
    case PadLaw::kNone:
      return 0;
    case PadLaw::kLinear:
      return pad.arm;
    case PadLaw::kHertz:
    case PadLaw::kModifiedHertz:
      return kHertzArm * contactRadius(pad, force);
    case PadLaw::kViscousSphere:
      return viscousSphereArm(pad.radius, force);
    case PadLaw::kFilledMembrane:
      return kUniformArm * contactRadius(pad, force);
  }
  return 0;
}

}  // namespace hapticd
