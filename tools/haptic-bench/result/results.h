/** @file
 * Results on disk: what --csv prints, read again, and two of them compared.
 */
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/result/tables.h"

namespace haptic_bench {

/** One benchmark's quantity with the values of its rounds. */
struct StoredResult {
  std::string benchmark;
  Series series;
  const TableColumn* column = nullptr;  ///< Whose rule it is judged by, if it is of a table and no time.
  std::size_t line = 0;                 ///< Where it begins in the file.
  std::string group;                    ///< Of a table's row: what it is judged together with.
  bool calm = false;                    ///< A row judged by the column's sharper rule.
};

/**
 * All series of a file that --csv wrote, in its order, and its comment lines (the machine). A row of a table is a
 * benchmark, named by its keys; each of its other columns is a series of one round.
 */
struct Results {
  std::vector<std::string> machine;
  std::map<std::string, std::string> settings;  ///< By the benchmark.
  std::vector<StoredResult> all;

  /** Throws Failure with `where` and the line. */
  [[nodiscard]] static Results parse(std::string_view text, const std::string& where);
  [[nodiscard]] static Results read(const std::string& path);
  [[nodiscard]] const StoredResult* find(const std::string& benchmark, const std::string& quantity) const;
  [[nodiscard]] bool holds(const std::string& benchmark) const;
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

/** Whether a quantity is compared. */
[[nodiscard]] bool isCompared(const StoredResult& result, const Comparison& what);

/** A quantity that changed. */
struct Change {
  enum class Kind {
    kWorse,
    kBetter,
    kMissing,
    kUnknown,     ///< See compare().
    kNoInterval,  ///< Of all slices of a run together: nobody knows how much that varies.
    kOtherUnit,   ///< A row of a vector unit that the other machine does not have, of errors across machines.
  } kind = Kind::kWorse;
  std::string benchmark, quantity, unit;
  Estimate before, after;
};

/** The first benchmark whose settings both files tell, and differently; empty if there is none. */
[[nodiscard]] std::string otherSettings(const Results& before, const Results& after);

/** Rounds of each side by which compare() judges all of it. */
[[nodiscard]] std::size_t roundsToJudge(const Results& before);

/**
 * Times change when their medians differ by more than 2 % and: of the middle one of many steps (a quantity that ends in
 * "median"), the intervals of the rounds do not meet; of others (means, tails, loading, and all of load, servo and ring
 * that runs against the clock) no round of one side lies within those of the other. Rounds that are too few, fewer than
 * six or so few that among all these quantities some would be set apart by chance, make it unknown.
 * Ratios and memory change by more than 2 %.
 * Errors, and what is counted, are deterministic: they change by more than 1e-9 of their unit, mean
 * squares after their root is taken (so that 1e-9 is in newtons). A hash changes for the worse. Less is better, but for
 * stiffness (N/m) and rates (1/s, 1/ms, Hz).
 * Columns of tables are judged by their rules (tables.h), their times as times; inf, nan and "-" are values.
 * Then judgeTogether().
 */
[[nodiscard]] std::vector<Change> compare(const Results& before, const Results& after, const Comparison& what);

/**
 * Columns of which single rows hang on a last bit: a group of six rows or more has changed when the mean of its rows'
 * changes (of logarithms; of mean squares of their roots) is more than the rule's and four times its standard error.
 */
[[nodiscard]] std::vector<Change> judgeTogether(const Results& before, const Results& after);

}  // namespace haptic_bench
