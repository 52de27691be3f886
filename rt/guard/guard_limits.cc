#include "rt/guard/guard_limits.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hapticd {
namespace {

constexpr double GuardLimits::*kLimitFields[] = {
    &GuardLimits::force,         &GuardLimits::torque,   &GuardLimits::force_slew, &GuardLimits::torque_slew,
    &GuardLimits::gripper_force, &GuardLimits::velocity, &GuardLimits::power,      &GuardLimits::active_power};
static_assert(sizeof kLimitFields / sizeof kLimitFields[0] * sizeof(double) == sizeof(GuardLimits),
              "every limit has its place here");

}  // namespace

bool valid(const GuardLimits& limits) HD_RT {
  return std::all_of(std::begin(kLimitFields), std::end(kLimitFields),
                     [&](auto field) HD_RT { return std::isfinite(limits.*field) && limits.*field >= 0; });
}

GuardLimits lower(const GuardLimits& a, const GuardLimits& b) HD_RT {
  GuardLimits least;
  for (const auto field : kLimitFields) least.*field = std::min(a.*field, b.*field);
  return least;
}

GuardLimits limitsOf(const DeviceLimits& order) HD_RT {
  GuardLimits limits;
  limits.force = order.force;
  limits.torque = order.torque;
  limits.force_slew = order.force_slew;
  limits.torque_slew = order.torque_slew;
  limits.velocity = order.velocity;
  limits.power = order.power;
  limits.active_power = order.active_power;
  limits.gripper_force = order.gripper_force;
  return limits;
}

DeviceLimits limitsOrder(std::uint32_t device, const GuardLimits& limits, bool only_lowers) HD_RT {
  return {device,
          only_lowers ? 1u : 0u,
          limits.force,
          limits.torque,
          limits.force_slew,
          limits.torque_slew,
          limits.velocity,
          limits.power,
          limits.active_power,
          limits.gripper_force};
}

}  // namespace hapticd
