#include "daemon/device/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

struct Field {
  const char* name;
  double GuardLimits::*value;
  LimitsConfig::Range range;
};
constexpr Field kFields[] = {
    {"force", &GuardLimits::force, LimitsConfig::kForce},
    {"torque", &GuardLimits::torque, LimitsConfig::kTorque},
    {"forceSlew", &GuardLimits::force_slew, LimitsConfig::kForceSlew},
    {"torqueSlew", &GuardLimits::torque_slew, LimitsConfig::kTorqueSlew},
    {"velocity", &GuardLimits::velocity, LimitsConfig::kVelocity},
    {"power", &GuardLimits::power, LimitsConfig::kPower},
    {"activePower", &GuardLimits::active_power, LimitsConfig::kPower},
    {"gripperForce", &GuardLimits::gripper_force, LimitsConfig::kGripperForce},
};
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

double knownOr(double value, double otherwise) { return value > 0 ? value : otherwise; }

}  // namespace

GuardLimits deviceMaxima(const DeviceInfo& info) {
  GuardLimits most;
  for (const Field& f : kFields) most.*f.value = kUnbounded;
  most.force = info.actuated_position ? knownOr(info.max_force, kUnbounded) : 0;
  most.torque = info.actuated_rotation ? knownOr(info.max_torque, kUnbounded) : 0;
  most.gripper_force = info.actuated_gripper ? knownOr(info.max_gripper_force, kUnbounded) : 0;
  most.velocity = knownOr(info.max_velocity, kUnbounded);
  return most;
}

GuardLimits startLimits(const LimitsConfig& config, const DeviceInfo& info) {
  GuardLimits wanted;
  wanted.force = config.force_n;
  wanted.torque = config.torque_nm;
  wanted.gripper_force = config.gripper_force_n;
  wanted.force_slew = config.force_slew_n_per_s;
  wanted.torque_slew = config.torque_slew_nm_per_s;
  wanted.velocity = config.velocity_m_per_s;
  wanted.power = config.power_w;
  wanted.active_power = config.active_power_w;
  GuardLimits limits = lower(wanted, deviceMaxima(info));
  if (info.continuous_force > 0) limits.force = std::min(limits.force, info.continuous_force);
  return limits;
}

bool raises(const GuardLimits& a, const GuardLimits& b) {
  return std::any_of(std::begin(kFields), std::end(kFields), [&](const Field& f) { return a.*f.value > b.*f.value; });
}

Result<void> checkMaxima(const GuardLimits& limits, const GuardLimits& maxima, const std::string& device) {
  for (const Field& f : kFields) {
    if (limits.*f.value <= maxima.*f.value) continue;
    return Error{ErrorCode::kInvalidArgument, std::string("limits.") + f.name,
                 fmt::format("{:g} is above what {} itself allows", limits.*f.value, device),
                 fmt::format("at most {:g}", maxima.*f.value)};
  }
  return {};
}

Result<GuardLimits> mergeLimits(const GuardLimits& now, GuardLimits wanted) {
  for (const Field& f : kFields) {
    double& value = wanted.*f.value;
    if (std::isnan(value) || value == now.*f.value) {
      value = now.*f.value;
      continue;
    }
    if (!std::isfinite(value) || value < 0) {
      return Error{ErrorCode::kInvalidArgument, std::string("limits.") + f.name,
                   fmt::format("{} is not a finite number of at least 0", value),
                   "NaN keeps the limit that is in force"};
    }
    const auto& [least, most] = f.range;
    if (value >= least && value <= most) continue;
    const bool is_slew = f.value == &GuardLimits::force_slew || f.value == &GuardLimits::torque_slew;
    return Error{ErrorCode::kInvalidArgument, std::string("limits.") + f.name,
                 is_slew && value < least ? fmt::format("at {:g} what the hand feels would hardly fall any more", value)
                                          : fmt::format("{:g} is beyond what the configuration may say", value),
                 fmt::format("{:g} to {:g}; NaN keeps the limit that is in force", least, most)};
  }
  return wanted;
}

}  // namespace hapticd
