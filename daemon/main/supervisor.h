/** @file
 * What the service manager is told: ready, status, watchdog.
 */
#pragma once

#include <cstdint>
#include <map>

#include "daemon/control/core.h"

namespace hapticd {

/**
 * Tells systemd READY=1 once every servo has run kCleanCycles, a STATUS= line each second, and WATCHDOG=1 only while
 * every servo's heartbeat advances: a dead servo gets the daemon restarted. Without systemd it does nothing but log.
 */
class Supervisor {
 public:
  static constexpr std::uint64_t kCleanCycles = 100;

  Supervisor(Core& core, bool notify);
  /** Call after every step of the Core. */
  void step();
  void stopping();
  [[nodiscard]] bool ready() const { return ready_; }

 private:
  bool heartbeatsAdvanced();

  Core& core_;
  bool notify_;
  bool ready_ = false;
  std::int64_t watchdog_ns_ = 0;  ///< Between pings; 0: no watchdog.
  std::int64_t next_ping_ns_ = 0;
  std::int64_t next_status_ns_ = 0;
  std::map<const GroupLink*, std::uint64_t> last_cycles_;
};

}  // namespace hapticd
