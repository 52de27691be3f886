/** @file
 * Hears that the machine goes to sleep, and holds that up until no force can reach a hand.
 *
 * A machine asleep runs nothing, but a device with a supply of its own may keep the force that it was last told. logind
 * says before it suspends, and waits, five seconds at most, for who holds a lock of kind "delay"
 * (https://systemd.io/INHIBITOR_LOCKS).
 */
#pragma once

#include <systemd/sd-bus.h>

#include <cstdint>
#include <functional>
#include <memory>

#include "daemon/control/core.h"
#include "daemon/ipc/unique_fd.h"

namespace hapticd {

/**
 * Before sleep every armed device is stopped, and none can be armed until the machine is awake again; what was stopped
 * then stays so until somebody arms it. Where logind gives no lock devices are stopped, but nothing waits for it; where
 * there is none nothing happens. Either is asked again every half minute. Control thread only.
 */
class SleepWatch {
 public:
  static constexpr std::int64_t kAgain_ns = 30'000'000'000;
  /** Awake, that is without the time asleep: whoever announced sleep has then forgotten it, or died. */
  static constexpr std::int64_t kFallingAsleep_ns = 120'000'000'000;
  /** A connection to the system's bus, as sd_bus_open_system(); tests give their own. */
  using Open = std::function<int(sd_bus**)>;

  explicit SleepWatch(Core& core, Open open = sd_bus_open_system);
  ~SleepWatch();
  SleepWatch(const SleepWatch&) = delete;
  SleepWatch& operator=(const SleepWatch&) = delete;

  /** Call after every step of the Core. Never waits. */
  void step();
  /** Whether sleep would be held up now. */
  [[nodiscard]] bool holds() const { return lock_.valid(); }

 private:
  struct Close {
    void operator()(sd_bus* bus) const { sd_bus_close_unref(bus); }
  };

  int connect();
  int takeLock();
  void lose(int error);
  void sleeps(bool asleep);
  static int onSleep(sd_bus_message* message, void* self, sd_bus_error*);
  static int onLock(sd_bus_message* message, void* self, sd_bus_error*);

  Core& core_;
  Open open_;
  std::unique_ptr<sd_bus, Close> bus_;
  UniqueFd lock_;
  bool asleep_ = false;
  std::int64_t since_ns_ = 0;  ///< When it was last told to be asleep.
  std::int64_t next_try_ns_ = 0;
  bool told_ = false;  ///< That nobody says when the machine sleeps.
};

}  // namespace hapticd
