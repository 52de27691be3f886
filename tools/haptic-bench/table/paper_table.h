/** @file
 * Tables 4.1, 4.2 and 4.3 of the thesis, measured again.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/bench.h"

namespace haptic_bench {

/** A table as it is shown, and the numbers behind it. */
struct PaperTable {
  std::string title;
  std::string settings;  ///< One line: what it was run with.
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<Series> series;
};

/** Spheres: the thesis's radius of 1 mm at 2000 N/m, and 50 mm at 100 and 1000 N/m. */
[[nodiscard]] std::vector<PaperTable> sphereTables(int rounds);
/** A plane touched with a probe: a synthetic recording, for the thesis's scan is not public. */
[[nodiscard]] PaperTable planeTable(int rounds);
/** The ridge of figure 4.6 at four angles. */
[[nodiscard]] PaperTable ridgeTable(int rounds);

/** All of them, in order. */
[[nodiscard]] std::vector<PaperTable> paperTables(int rounds);

}  // namespace haptic_bench
