#include "rt/scene/foreseen.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rt/base/rotation.h"

namespace hapticd {
namespace {

double distanceFrom(const Vec3& way, const Vec3& step) HD_RT {
  const double squared = way.squaredNorm();
  const double along = squared > 0 ? std::clamp(step.dot(way) / squared, 0.0, 1.0) : 0;
  return (step - along * way).norm();
}

}  // namespace

bool isForeseen(const Step& step, double aside) HD_RT {
  const auto middleAt = [&](const Pose& X) HD_RT { return Vec3(X.p + X.q * step.middle_O); };
  const Vec3 from = middleAt(step.before), moved = middleAt(step.now) - from;
  // Most steps are small. The sine of half an angle is at least the angle over pi.
  const double cosine = step.now.q.coeffs().dot(step.before.q.coeffs());
  const double most = std::numbers::pi * std::sqrt(std::max(0.0, 1 - cosine * cosine));
  if (moved.norm() + most * step.lever <= aside) return true;
  const Quat back = step.before.q.conjugate();
  const double turn = distanceFrom(rotationVector(step.foreseen.q * back), rotationVector(step.now.q * back));
  return distanceFrom(middleAt(step.foreseen) - from, moved) + turn * step.lever <= aside;
}

}  // namespace hapticd
