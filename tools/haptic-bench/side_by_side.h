/** @file
 * Several algorithms' results side by side.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/bench.h"

namespace haptic_bench {

/** One of several that are compared; its name begins the names of its series. */
struct Contender {
  std::string name;
  std::vector<Series> series;
};

/** As print(); as a table a line for each, and the medians of each quantity below one another. One alone as print(). */
void printSideBySide(const Common& common, const std::string& benchmark, const std::vector<Contender>& all);

}  // namespace haptic_bench
