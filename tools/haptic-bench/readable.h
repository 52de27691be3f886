/** @file
 * Units in which a number is read without counting its digits.
 */
#pragma once

#include <string>

namespace haptic_bench {

/** Another unit of the same kind, and what a value is multiplied by to be in it. */
struct Readable {
  std::string unit;
  double factor = 1;
};

/** That in which the value has no more than four digits before the point, and one of the first two behind it; `unit`
 * itself if it is in it, or is of no kind that has several. */
[[nodiscard]] Readable readable(const std::string& unit, double value);

}  // namespace haptic_bench
