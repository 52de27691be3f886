/** @file
 * Times in nanoseconds, as tests write them.
 */
#pragma once

#include <cstdint>

namespace hapticd {

inline constexpr std::int64_t kMs = 1'000'000;  ///< A millisecond, and the usual tick [ns].

}  // namespace hapticd
