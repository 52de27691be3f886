/** @file
 * Tables 4.1, 4.2 and 4.3 of the thesis, measured again.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/bench.h"

namespace haptic_bench {

/** What one algorithm did on one model. */
struct PaperCell {
  std::string model;
  std::size_t triangles = 0;
  std::string algorithm;
  std::vector<Series> series;  ///< As describe() has them, without a name in front.
};

/** A table as it is shown, and the numbers behind it. */
struct PaperTable {
  std::string title;
  std::string settings;  ///< One line: what it was run with.
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<Series> series;
  std::vector<PaperCell> cells;  ///< Model by model; none where an algorithm refuses one.
};

/** The algorithms of a table or figure, and of those asked for what is not among them. */
[[nodiscard]] std::vector<std::string> withMore(std::vector<std::string> own, const std::vector<std::string>& more);

/**
 * Tables 4.1 to 4.3, in order. Spheres: the thesis's radius of 1 mm at 2000 N/m, and 50 mm at 100 and 1000 N/m; a plane
 * touched with a probe: a synthetic recording, for the thesis's scan is not public; the ridge of figure 4.6 at four
 * angles. `more` algorithms stand beside their own; where one refuses a model, standard error says why.
 */
[[nodiscard]] std::vector<PaperTable> paperTables(int rounds, const std::vector<std::string>& more = {});

}  // namespace haptic_bench
