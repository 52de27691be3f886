/** @file
 * Counts since the servo's start, or since a moment that a user chose (key c of top).
 */
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/hapticctl/daemon.h"

namespace hapticctl {

/**
 * Statistics of each device of a status, by its place there; null for one that has been closed since. `reset`: their
 * histograms begin anew, which takes administration.
 */
[[nodiscard]] std::vector<Owned<haptic_statistics>> statisticsOf(const Daemon& daemon, const haptic_status& status,
                                                                 bool reset = false);

/** What is counted of a device. */
struct DeviceCounts {
  std::uint64_t missed = 0, stale = 0;
  std::uint64_t answers = 0;    ///< Of the collide thread, on what is held or moves freely.
  std::uint64_t cut_short = 0;  ///< Of them, for want of time or work.
  std::uint64_t lost = 0;       ///< Of them: the servo had no room.
};

/** Of the device's servo since its start. `statistics` may be null: then nothing is known of the collide thread. */
[[nodiscard]] DeviceCounts countsOf(const haptic_device_status& device, const haptic_statistics* statistics);

/** "sim: collisions: 1 200 answers, 3 cut short, 0 lost", as a warning if some were. */
[[nodiscard]] std::string collideLine(const std::string& device, const DeviceCounts& counts);

/** What the counts were at a moment, to start anew from there. */
class Baseline {
 public:
  using ClientCounts = std::array<std::uint64_t, 3>;  ///< Received, rejected, stale.

  void take(const haptic_device_status& device, const haptic_statistics* statistics);
  void take(const haptic_client_status& client);
  /** What has been counted since; all of it for who was not there, or has begun anew meanwhile. */
  [[nodiscard]] DeviceCounts since(const haptic_device_status& device, const haptic_statistics* statistics) const;
  [[nodiscard]] ClientCounts since(const haptic_client_status& client) const;

 private:
  std::map<std::string, DeviceCounts> devices_;    ///< By URI.
  std::map<std::uint64_t, ClientCounts> clients_;  ///< By session.
};

}  // namespace hapticctl
