#include "tools/haptic-emu/woodyhid/woody_hid_arm.h"

#include <cmath>
#include <numbers>

namespace haptic_emu {
namespace {

struct Drive {
  double ratio;  ///< Turns of the motor for one of the body; negative: the other way round.
  double counts, newton_metres_per_ampere;
};

const std::array<Drive, 3> kWooden = {{{16, 2000, 0.0259}, {12, 2000, 0.0259}, {12, 2000, 0.0259}}};
const std::array<Drive, 3> kPolhem = {
    {{175 / 28.8, 4096, 0.0603}, {-100 / 13.0, 4096, 0.0538}, {100 / 10.0, 4096, 0.0538}}};
const std::array<Drive, 3>& drives(WoodyKind kind) { return kind == WoodyKind::kPolhem3 ? kPolhem : kWooden; }

struct Point {
  double r = 0, z = 0;
};

/** Where circles about a and b meet, on the left of the way from a to b. */
Point meet(Point a, double at_a, Point b, double at_b) {
  const double dr = b.r - a.r, dz = b.z - a.z, d = std::hypot(dr, dz);
  const double along = (d * d + at_a * at_a - at_b * at_b) / (2 * d);
  const double across = std::sqrt(at_a * at_a - along * along);
  return {a.r + (along * dr - across * dz) / d, a.z + (along * dz + across * dr) / d};
}

}  // namespace

Vec3 woodyJoints(WoodyKind kind, const Vec3& p) {
  if (kind == WoodyKind::kWooden2015) {
    const double x = p.x() + 0.220, y = p.y(), z = p.z() + 0.080;
    const Point shoulder{0, 0.080}, tip{std::hypot(x, y), z};
    const Point elbow = meet(shoulder, 0.205, tip, 0.245);  // above the way to the tip
    // B from the upright, C from hanging down.
    return {std::atan2(y, x), std::atan2(elbow.r, elbow.z - shoulder.z), std::atan2(tip.r - elbow.r, elbow.z - tip.z)};
  }
  const double x = p.x() + 0.2045, y = p.y(), z = p.z() + 0.0325;
  // Where A is turned past a quarter the tip is before the axis all the same.
  const Point motor_b{0.017, 0}, motor_c{-0.017, 0}, tip{std::hypot(x, y), z};
  const Point elbow = meet(motor_b, 0.165, tip, 0.1308);
  const double ur = (tip.r - elbow.r) / 0.1308, uz = (tip.z - elbow.z) / 0.1308;
  const Point behind{elbow.r - 0.034 * ur, elbow.z - 0.034 * uz};
  const Point crank = meet(motor_c, 0.025, behind, 0.190);
  double c = std::atan2(crank.z, crank.r - motor_c.r);
  if (c < 0.5) c += 2 * std::numbers::pi;
  return {std::atan2(y, x), std::atan2(elbow.z, elbow.r - motor_b.r), c};
}

Vec3 woodyCounts(WoodyKind kind, const Vec3& joints) {
  Vec3 counts;
  for (int i = 0; i < 3; ++i) {
    const Drive& drive = drives(kind)[static_cast<std::size_t>(i)];
    counts[i] = joints[i] * drive.ratio * drive.counts / (2 * std::numbers::pi);
  }
  return counts;
}

Vec3 woodyForce(WoodyKind kind, const Vec3& p, const Vec3& amperes) {
  constexpr double kStep = 1e-6;
  Vec3 force = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = kStep * Vec3::Unit(axis);
    const Vec3 turned = (woodyJoints(kind, p + step) - woodyJoints(kind, p - step)) / (2 * kStep);
    for (int i = 0; i < 3; ++i) {
      const Drive& drive = drives(kind)[static_cast<std::size_t>(i)];
      force[axis] += amperes[i] * drive.newton_metres_per_ampere * drive.ratio * turned[i];
    }
  }
  return force;
}

}  // namespace haptic_emu
