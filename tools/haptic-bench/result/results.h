/** @file
 * Results on disk: what --csv prints, read again, and two of them compared.
 */
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tools/haptic-bench/bench.h"

namespace haptic_bench {

/** One benchmark's quantity with the values of its rounds. */
struct StoredResult {
  std::string benchmark;
  Series series;
};

/** All series of a file that --csv wrote, in its order, and its comment lines (the machine). */
struct Results {
  std::vector<std::string> machine;
  std::vector<StoredResult> all;

  /** Throws Failure with `where` and the line. */
  [[nodiscard]] static Results parse(std::string_view text, const std::string& where);
  [[nodiscard]] static Results read(const std::string& path);
  [[nodiscard]] const Series* find(const std::string& benchmark, const std::string& quantity) const;
};

/** Whether both were measured by one build on one machine; its load, which is never the same, aside. */
[[nodiscard]] bool sameMachine(const Results& a, const Results& b);

/** A field of a CSV line, in quotes where it needs them. */
[[nodiscard]] std::string csvField(const std::string& text);

/** What is compared. */
struct Comparison {
  bool times = true;    ///< Times, ratios and memory. Only within one machine.
  bool hashes = false;  ///< Hashes of forces. Only within one build and instruction set.
};

/** Whether a quantity of that unit is compared. */
[[nodiscard]] bool isCompared(const std::string& unit, const Comparison& what);

/** A quantity that changed. */
struct Change {
  enum class Kind { kWorse, kBetter, kMissing, kUnknown } kind = Kind::kWorse;  ///< kUnknown: see compare().
  std::string benchmark, quantity, unit;
  Estimate before, after;
};

/** Rounds of each side by which compare() judges all of it. */
[[nodiscard]] std::size_t roundsToJudge(const Results& before);

/**
 * Times change when their medians differ by more than 2 % and: of the middle one of many steps (a quantity that ends in
 * "median"), the intervals of the rounds do not meet; of others (means, tails, loading, and all of load, servo and ring
 * that runs against the clock) no round of one side lies within those of the other. Rounds that are too few, fewer than
 * six or so few that among all these quantities some would be set apart by chance, make it unknown.
 * Ratios and memory change by more than 2 %.
 * Errors, and what is counted in each tick, are deterministic: they change by more than 1e-9 of their unit, mean
 * squares after their root is taken (so that 1e-9 is in newtons). A hash changes for the worse. Less is better, but for
 * stiffness (N/m) and rates (1/s, Hz).
 */
[[nodiscard]] std::vector<Change> compare(const Results& before, const Results& after, const Comparison& what);

}  // namespace haptic_bench
