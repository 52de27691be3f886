/** @file
 * Brings devices to zero whose daemon is dead, each in a process of its own, within a stated time.
 */
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/** All devices together take no longer: one that hangs is left behind. */
inline constexpr std::chrono::milliseconds kSafeWithin{1800};

struct MadeSafe {
  std::string uri;
  bool ok = false;
  std::string text;  ///< Why it was not; else empty.
};

/** What brings one device to zero: zeroDevice() of the registry, or a test's own. */
using SafeOne = std::function<Result<void>(const std::string& uri)>;

/**
 * Calls `one` for each URI in a child process, all at once, and waits at most `within`; whoever is not done then is
 * killed, and left behind where the kernel does not let go of it. `one` finds no descriptors open but the standard
 * ones, so that one left behind holds no lock of ours. Call it while the process has one thread. One result
 * for each, in order.
 */
[[nodiscard]] std::vector<MadeSafe> makeSafe(const std::vector<std::string>& uris, const SafeOne& one,
                                             std::chrono::milliseconds within = kSafeWithin);

}  // namespace hapticd
