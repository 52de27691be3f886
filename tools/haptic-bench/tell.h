/** @file
 * What a user should know beside the results: lines on the standard error.
 */
#pragma once

#include <string>

namespace haptic_bench {

/** "haptic-bench: LINE" on the standard error, but once, however often a sweep reads the same file. */
void tellOnce(const std::string& line);

/** "   12 s  WHAT" on the standard error: what begins now, so many seconds after the first, where all takes minutes. */
void tellTime(const std::string& what);

}  // namespace haptic_bench
