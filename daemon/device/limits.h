/** @file
 * How strong a device may be: the lower of what the configuration allows and what the device can.
 */
#pragma once

#include "daemon/config/config.h"
#include "rt/device.h"
#include "rt/guard/guard.h"

namespace hapticd {

/** What the device itself bounds; infinite where it says nothing. Torque is zero where rotation is not actuated. */
[[nodiscard]] GuardLimits deviceMaxima(const DeviceInfo& info);

/** The limits a device starts with: the configuration's, the device's, and its continuous force. */
[[nodiscard]] GuardLimits startLimits(const LimitsConfig& config, const DeviceInfo& info);

/** Some limit of `a` is above that of `b`. */
[[nodiscard]] bool raises(const GuardLimits& a, const GuardLimits& b);

/** kInvalidArgument names the first limit that is above what the device allows. */
[[nodiscard]] Result<void> checkMaxima(const GuardLimits& limits, const GuardLimits& maxima, const std::string& device);

/** NaN in `wanted` keeps what `now` has. kInvalidArgument names the field that is no number or beyond what the
 * configuration may say; what stays as it is may be so. */
[[nodiscard]] Result<GuardLimits> mergeLimits(const GuardLimits& now, GuardLimits wanted);

}  // namespace hapticd
