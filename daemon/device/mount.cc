#include "daemon/device/mount.h"

#include <algorithm>

namespace hapticd {
namespace {

constexpr double kDegree = M_PI / 180;  // [rad]
/** Nearer to straight up or down there is one turn about z alone. */
constexpr double kUpright = 1 - 1e-12;
/** So that who has said 30 degrees reads 30, and not 29.999999999999996. */
constexpr double kPerDegree = 1e9;

}  // namespace

Quat fromDegrees(const Vec3& degrees) {
  const auto about = [&](int axis) { return Quat(Eigen::AngleAxisd(degrees[axis] * kDegree, Vec3::Unit(axis))); };
  return (about(2) * about(1) * about(0)).normalized();
}

Vec3 toDegrees(const Quat& q) {
  const Mat3 R = q.normalized().toRotationMatrix();
  const double up = std::clamp(0 - R(2, 0), -1.0, 1.0);  // Of no turn 0, and not -0.
  Vec3 angle(std::atan2(R(2, 1), R(2, 2)), std::asin(up), std::atan2(R(1, 0), R(0, 0)));
  if (std::abs(up) > kUpright) angle = {0, std::copysign(M_PI_2, up), std::atan2(-R(0, 1), R(1, 1))};
  return (angle / kDegree * kPerDegree).array().round() / kPerDegree + 0.0;  // No -0.
}

}  // namespace hapticd
