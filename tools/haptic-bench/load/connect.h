/** @file
 * The client library's results as exceptions of the benchmark.
 */
#pragma once

#include <hapticclient/hapticclient.hpp>
#include <string>
#include <utility>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

/** The value, or a Failure with the error's own words. */
template <class T>
[[nodiscard]] T check(haptic::Result<T> result) {
  if (!result) throw Failure(result.error().message());
  return std::move(*result);
}
inline void check(const haptic::Result<void>& result) {
  if (!result) throw Failure(result.error().message());
}

[[nodiscard]] inline haptic::Client connectTo(const std::string& socket) {
  return check(haptic::Client::connect({.socket = socket, .name = "haptic-bench"}));
}

}  // namespace haptic_bench
