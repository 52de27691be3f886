#include "drivers/spacemouse/cap_pose.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

double beyond(double counts, double dead_zone) HD_RT {
  const double share = std::clamp(counts / spacemouse::kFull, -1.0, 1.0);
  const double left = std::max(0.0, std::abs(share) - dead_zone) / (1 - dead_zone);
  return std::copysign(left, share);
}

Quat turnedBy(const Vec3& rotation) HD_RT {
  const double angle = rotation.norm();
  return angle > 0 ? Quat(Eigen::AngleAxisd(angle, rotation / angle)) : Quat::Identity();
}

}  // namespace

CapDeflection capDeflection(const spacemouse::State& state, double dead_zone) HD_RT {
  const auto axis = [&](std::size_t i) noexcept { return beyond(state.axis[i], dead_zone); };
  // The device's x goes to the right, its y toward the user, its z down; its rotations turn about the same axes.
  return {Vec3(axis(1), axis(0), -axis(2)), Vec3(axis(4), axis(3), -axis(5))};
}

void CapPose::step(const CapDeflection& cap, double dt) HD_RT {
  if (!rate_) {
    pose_.p = parameters_.travel * cap.shift;
    pose_.q = turnedBy(parameters_.turn * cap.turn);
    return;
  }
  const Vec3 box = Vec3::Constant(parameters_.box);
  pose_.p = (pose_.p + dt * parameters_.speed * cap.shift).cwiseMax(-box).cwiseMin(box);
  pose_.q = rotated(pose_.q, parameters_.turn_speed * cap.turn, dt);
}

}  // namespace hapticd
