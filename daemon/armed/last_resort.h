/** @file
 * The devices' last resort: when the daemon dies of a signal, a servo that computed beyond RLIMIT_RTTIME or a crash,
 * each open device is brought to zero first.
 */
#pragma once

#include "rt/device.h"

namespace hapticd {

/**
 * From now on each signal that would end the process, of a crash or sent by somebody, calls safe() of every device held
 * below before it does. Not SIGTERM, SIGINT, SIGPIPE and SIGXFSZ, for which the daemon has better; nor what is ignored
 * or handled already. Once, before any thread.
 */
void installLastResort() noexcept;

/** Holds a device for the last resort while it lives. Control thread; the device outlives it. */
class LastResort {
 public:
  /** More devices than a daemon can open are not held. */
  explicit LastResort(Device& device) noexcept;
  LastResort(const LastResort&) = delete;
  LastResort& operator=(const LastResort&) = delete;
  ~LastResort();

 private:
  Device* device_;
};

}  // namespace hapticd
