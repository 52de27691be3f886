/** @file
 * The device groups that the configuration wants: opened at start, and looked for again while they are missing.
 */
#pragma once

#include <cstdint>
#include <list>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/device/device_manager.h"
#include "rt/base/clock.h"

namespace hapticd {

/**
 * A device that does not answer keeps neither the daemon nor the other groups from starting. Its group is missing,
 * which is said once, and is tried again: after a second, then at intervals that double up to half a minute, and at
 * once when a client asks for one of its devices.
 *
 * Groups are opened side by side. At start each counts after those before it, so that numbers, names and messages come
 * in the order of the configuration; the start waits for a silent one no longer than kPatience_ns, and then it holds
 * nobody.
 *
 * A group that takes whatever there is (an empty URI) begins when those before it have ended. It takes the next device
 * that no group names, in the end the simulator; what it has passed over is told but not tried again. It passes over
 * what does not open itself, not what waits for another device of its group.
 *
 * One that was closed is not wanted any more; but who asks for one of its devices gets the whole group: the others, a
 * dead-man switch among them, its rate and its processors are as much the configuration's as the device. Of a group
 * that took whatever there was that is the device which it had.
 *
 * Control thread only.
 */
class WantedGroups {
 public:
  static constexpr std::int64_t kPatience_ns = 10'000'000'000;  ///< Longest that a start waits for devices.
  static constexpr std::int64_t kFirstRetry_ns = 1'000'000'000, kMostRetry_ns = 30'000'000'000;

  /** A device that is to be open and is not. */
  struct Absent {
    std::string group, uri;
    Error why;
    bool passed_over = false;  ///< Its group has taken another.
  };

  WantedGroups(DeviceManager& devices, Clock& clock);

  /** Begins; once. An error is one of the configuration, which no attempt would mend: nothing is opened then. */
  [[nodiscard]] Result<void> begin(const std::vector<GroupConfig>& groups);
  /** Each group has had its first attempt, or the start has waited for them long enough. */
  [[nodiscard]] bool settled() const;
  void poll();
  /** The group of that name was closed, if it is one of these; of its devices the canonical URIs, in their order. */
  void closed(const std::string& name, std::vector<std::string> canonical);

  /** As they are now. */
  [[nodiscard]] std::vector<Absent> absent() const;
  /** Whether it is the URI of a device that is missing, or closed, as configured or as its driver writes it. */
  [[nodiscard]] bool names(std::string_view uri) const;
  /** The first error by which the daemon itself may not go on: no right to real-time scheduling. */
  [[nodiscard]] const Result<void>& fatal() const { return fatal_; }

 private:
  struct Wanted {
    GroupConfig group;
    std::vector<std::string> canonical;   ///< Of each device, as last known; empty: only a serial number is.
    std::vector<std::string> candidates;  ///< For an empty URI: those not tried yet, first one first.
    Error why;
    std::int64_t next_ns = 0, pause_ns = kFirstRetry_ns;
    bool trying = false, tried = false, told = false;
    bool rests = false;  ///< It was closed: nobody looks for it until somebody asks.
  };

  Result<std::string> advise(const std::string& canonical);
  void recognise(Wanted& wanted) const;
  void attempt(Wanted& wanted);
  void answered(Wanted& wanted, const GroupConfig& tried, const Result<void>& result);
  void miss(Wanted& wanted, const Error& why);
  [[nodiscard]] bool patient() const { return clock_.now() - began_ns_ < kPatience_ns; }
  /** Whether nothing before it in the configuration is awaited. */
  [[nodiscard]] bool turnOf(const Wanted& wanted) const;
  /** The devices that this group would open now. */
  [[nodiscard]] static GroupConfig next(const Wanted& wanted);

  DeviceManager& devices_;
  Clock& clock_;
  std::list<Wanted> wanted_;  ///< Those not open; stays where it is while it is tried.
  std::vector<GroupConfig> configured_;
  std::vector<Absent> passed_over_;
  std::int64_t began_ns_ = 0;
  Result<void> fatal_;
};

}  // namespace hapticd
