/** @file
 * Time as the servo sees it: a monotonic clock that can be waited on, real or moved by hand.
 */
#pragma once

#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/** Source of time and of waiting. Times are nanoseconds on one monotonic axis. */
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual std::int64_t now() HD_RT = 0;
  /** Returns at or after the absolute time; at once if it has passed. */
  virtual void sleepUntil(std::int64_t t_ns) HD_RT = 0;
};

/** CLOCK_MONOTONIC and clock_nanosleep with an absolute time. */
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] std::int64_t now() HD_RT override;
  void sleepUntil(std::int64_t t_ns) HD_RT override;
};

/** A clock that moves only when told to; waiting moves it to the time waited for. */
class ManualClock final : public Clock {
 public:
  explicit ManualClock(std::int64_t t_ns = 0) noexcept : t_ns_(t_ns) {}
  [[nodiscard]] std::int64_t now() HD_RT override { return t_ns_; }
  void sleepUntil(std::int64_t t_ns) HD_RT override {
    if (t_ns > t_ns_) t_ns_ = t_ns;
  }
  void advance(std::int64_t by_ns) HD_RT { t_ns_ += by_ns; }

 private:
  std::int64_t t_ns_;
};

}  // namespace hapticd
