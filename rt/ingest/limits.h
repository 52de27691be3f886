/** @file
 * What a client's message may ask for. Anything beyond is refused with kInvalidArgument, whole; nothing is clamped
 * silently. These bounds keep the arithmetic of the servo sane; what reaches the hand is bound by the guard.
 */
#pragma once

#include <cstdint>

#include "rt/command.h"
#include "rt/cycle/cycle_input.h"

namespace hapticd::limits {

inline constexpr double kCoordinate = 100;      ///< Any coordinate, radius or offset, absolute [m].
inline constexpr double kSpeed = 100;           ///< Each component of an object's velocity, absolute [m/s].
inline constexpr double kAngularSpeed = 1000;   ///< Each component of an object's angular velocity, absolute [rad/s].
inline constexpr double kUnitTolerance = 1e-3;  ///< | |n| - 1 | up to which a direction is normalised, not refused.
inline constexpr double kStiffness = 1e5;       ///< [N/m]; also each entry of a Jacobian, absolute.
inline constexpr double kDamping = 1e3;         ///< [N s/m]
inline constexpr double kFriction = 5;          ///< Coefficient; the dynamic one is at most the static one.
inline constexpr double kForce = 1e3;           ///< Magnitude [N].
inline constexpr double kTorque = 1e2;          ///< Magnitude [N m].
inline constexpr double kGripper = 6.5;         ///< Opening, absolute [rad]; a little over a turn.
inline constexpr double kRadiusMin = 1e-6;      ///< Smallest sphere or field [m].
inline constexpr std::int64_t kLeaseNs = 10'000'000'000;  ///< Longest lease; it is above zero.
inline constexpr std::int64_t kBlendNs = 1'000'000'000;   ///< Longest blend; zero asks for the shortest there is.

/** Commands of one session that may wait in the cycle for their tick. */
inline constexpr std::uint32_t kWaitingPerSession = 8;
/** Commands a session is sure of in each tick, whatever the others do. */
inline constexpr std::uint32_t kFairShare = kIngestCommandsPerCycle / kMaxSessions;
static_assert(kFairShare >= 1);

}  // namespace hapticd::limits
