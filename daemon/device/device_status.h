/** @file
 * A device or session as it stands now, gathered from what the servo publishes.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "daemon/session/session.h"

namespace hapticd {

struct DeviceNow {
  hd_sample sample{};  ///< Zeros before the first cycle.
  bool armed = false;  ///< Forces may reach it: also while its driver has not sent the zeros.
  double rate_hz = 0;
  std::uint64_t cycles = 0, missed = 0, overruns = 0, stale = 0;
  double heat = 0;  ///< Of the motors, estimated; 1: all they stand for ever.
  double busy = 0;  ///< Median share of the period spent in the cycle.
  std::uint64_t wake_p99_ns = 0;
  std::string policy;  ///< "SCHED_FIFO 80" or "SCHED_OTHER"
};
[[nodiscard]] DeviceNow statusOf(const OpenDevice& device);

struct SessionNow {
  std::uint64_t received = 0, rejected = 0, stale = 0, violations = 0, applied_seq = 0;
  std::uint32_t models = 0;  ///< Local models in force.
  float fade = 0;
  std::int64_t heartbeat_age_ns = 0;
};
[[nodiscard]] SessionNow statusOf(const Session& session);

/** Answers of a group's collide thread; as ColliderCounters. */
struct CollideNow {
  std::uint64_t queries = 0, exhausted = 0, unsent = 0;
};
[[nodiscard]] CollideNow collideOf(DeviceGroup& group);

/** A stage of the cycle, or of what runs beside it, with its histogram. */
struct Stage {
  const char* name;
  Histogram* histogram;
};
[[nodiscard]] std::array<Stage, 7> stagesOf(DeviceGroup& group);

}  // namespace hapticd
