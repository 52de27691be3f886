/** @file
 * The tables that --csv prints of benchmarks with columns of their own: what each column is, and how compare judges it.
 * Printers take their headers from here, so a column cannot be printed without standing here.
 */
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haptic_bench {

/** How a number is judged that repeats from run to run, so that one reading is enough. */
struct Rule {
  enum class Better {
    kLess,  ///< Below zero is as good as zero.
    kMore,
    kNearOne  ///< A ratio that should be one.
  } better = Better::kLess;
  double absolute = 0;  ///< Differences up to this mean nothing, in the column's unit,
  double relative = 0;  ///< nor those up to this part of the smaller value.
  /**
   * Of what a last bit decides in single rows: how far all rows of a group must have moved, as a part, or of mean
   * squares by their root. 0: single rows say it all.
   */
  double together = 0;
};

struct TableColumn {
  enum class Role {
    kKey,      ///< Names the row, with the other keys,
    kGroup,    ///< and rows that are judged together.
    kRepeats,  ///< By its rule.
    kMemory,   ///< By its rule, within one machine.
    kTimed,    ///< As times are: one reading is never judged.
    kAside     ///< Not compared.
  };
  const char* name;
  Role role;
  const char* unit;  ///< Of keys that are words: empty.
  Rule rule{};
  Rule calm{};  ///< In rows that are calm, if it is sharper there.
};

struct TableForm {
  const char* benchmark;
  std::span<const TableColumn> columns;
  /** A row is calm whose key of that name is at most so much; null: none is. */
  const char* calm_key = nullptr;
  double calm_most = 0;
  [[nodiscard]] std::string header() const;
};

/** zwidth, sixdof, stability, collide, and the three of grasp. */
[[nodiscard]] std::span<const TableForm> tableForms();
/** Of one of these. */
[[nodiscard]] const TableForm& tableForm(std::string_view benchmark);

/** Whether the line is that table's header, as it is printed. */
[[nodiscard]] const TableForm* formOfHeader(std::string_view line);
/** What is wrong with a header that is nearly one of a table, or of a table that no longer is; empty: it is no header.
 */
[[nodiscard]] std::string faultOfHeader(const std::vector<std::string>& fields);

/** A cell with a number: "-", "nan" and nothing are none, "true" is 1. False: it is no number. */
[[nodiscard]] bool readCell(std::string_view cell, double& value);

/** 1: `after` is worse than `before`, -1: better, 0: it makes no difference. No number is worse than any. */
[[nodiscard]] int judgeByRule(const Rule& rule, double before, double after);

}  // namespace haptic_bench
