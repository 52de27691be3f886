#include "rt/base/rotation.h"

namespace hapticd {

Vec3 rotationVector(const Quat& q) HD_RT {
  const double sine = q.vec().norm();
  // For small angles sine / w is the half angle to rounding; the limit of 2 atan2(s, w) / s is 2 / w.
  if (sine < 1e-12) return q.vec() * (q.w() < 0 ? -2.0 : 2.0);
  const double sign = q.w() < 0 ? -1 : 1;
  return q.vec() * (2 * sign * std::atan2(sine, std::abs(q.w())) / sine);
}

Quat fromRotationVector(const Vec3& r) HD_RT {
  const double angle = r.norm();
  if (angle < 1e-12) return Quat(1, r.x() / 2, r.y() / 2, r.z() / 2).normalized();
  const Vec3 axis = r * (std::sin(angle / 2) / angle);
  return {std::cos(angle / 2), axis.x(), axis.y(), axis.z()};
}

}  // namespace hapticd
