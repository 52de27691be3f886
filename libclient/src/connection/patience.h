/** @file
 * How long a caller is willing to wait.
 */
#pragma once

#include <algorithm>
#include <cstdint>

namespace hapticd::client {

/** Whoever would wait for ever waits a year: now plus any number of nanoseconds is no time on a clock. */
inline constexpr std::int64_t kLongestWait_ns = INT64_C(365) * 24 * 3600 * 1'000'000'000;

/** What was asked for, or the default if that is not above zero. */
constexpr std::int64_t patience_ns(std::int64_t asked_ns, std::int64_t default_ns) noexcept {
  return asked_ns > 0 ? std::min(asked_ns, kLongestWait_ns) : default_ns;
}

}  // namespace hapticd::client
