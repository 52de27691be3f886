#include "tools/haptic-emu/falcon/falcon_arm.h"

#include <cmath>
#include <numbers>

namespace haptic_emu {
namespace {

constexpr double kDegreesPerCount = 0.0364347;  // libnifalcon's FalconGeometry.h
constexpr double kDegreesAtZero = 35;
constexpr double kCountsPerNewtonMetre = 10'000;

/** Angle of arm i from the horizontal: the triangle of arm, leg and the line from the arm's joint to the grip. */
double armDegrees(const Vec3& p, int i) {
  constexpr double kArm = 0.060, kLeg = 0.1025, kPlatform = 0.01443, kEnds = 0.01125 + 0.01125;
  constexpr double kSide = -0.025, kBase = 0.0400, kBaseSide = -0.02309;
  const double turn = (90.0 - 120.0 * i + 15.0) * std::numbers::pi / 180;
  const double outward = p.x() * std::cos(turn) + p.y() * std::sin(turn) - kBase + kPlatform;
  const double sideways = p.y() * std::cos(turn) - p.x() * std::sin(turn) - kBaseSide + kSide;
  const double leg = kEnds + std::sqrt(kLeg * kLeg - sideways * sideways);
  const double line = std::hypot(outward, p.z());
  const double corner = std::acos((line * line + kArm * kArm - leg * leg) / (2 * line * kArm));
  return (std::atan2(p.z(), outward) - corner) * 180 / std::numbers::pi;
}

Vec3 armDegrees(const Vec3& p) { return {armDegrees(p, 0), armDegrees(p, 1), armDegrees(p, 2)}; }

}  // namespace

Vec3 falconCounts(const Vec3& p) { return (armDegrees(p) - Vec3::Constant(kDegreesAtZero)) / kDegreesPerCount; }

Vec3 falconForce(const Vec3& p, const std::array<std::int16_t, 3>& motor) {
  const Vec3 torques = -Vec3(motor[0], motor[1], motor[2]) / kCountsPerNewtonMetre;
  Vec3 force;
  for (int axis = 0; axis < 3; ++axis) {
    constexpr double kStep = 1e-6;  // [m]
    const Vec3 turned =
        (armDegrees(p + kStep * Vec3::Unit(axis)) - armDegrees(p - kStep * Vec3::Unit(axis))) * std::numbers::pi / 180;
    force[axis] = torques.dot(turned) / (2 * kStep);
  }
  return force;
}

}  // namespace haptic_emu
