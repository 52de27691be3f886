/** @file
 * A subscription to events, taken from its queue.
 */
#pragma once

#include <hapticclient/events.h>

#include <chrono>
#include <hapticclient/result.hpp>
#include <memory>

namespace haptic {

class Events {
 public:
  explicit Events(haptic_events* handle) noexcept : handle_(handle) {}

  /** The oldest event; HAPTIC_TIMEOUT when none came in time. A negative time waits for ever. */
  Result<haptic_event> next(std::chrono::nanoseconds timeout) {
    haptic_event event;
    event.size = sizeof event;
    const int code = haptic_events_next(handle_.get(), &event, timeout.count());
    if (code != HAPTIC_OK) return Error{code, {}, {}, {}};
    return event;
  }
  /** Polls readable while events wait. */
  [[nodiscard]] int fd() const noexcept { return haptic_events_fd(handle_.get()); }

 private:
  struct Close {
    void operator()(haptic_events* handle) const noexcept { haptic_events_close(handle); }
  };
  std::unique_ptr<haptic_events, Close> handle_;
};

}  // namespace haptic
