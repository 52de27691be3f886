/** @file
 * Columns of numbers from a text file, found by name.
 */
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/math.h"

namespace haptic_bench {

/** Every row whole, at least one row, every number of a column that is asked for finite. */
class Table {
 public:
  static constexpr std::size_t kMaxBytes = 1u << 30;
  static constexpr std::size_t kMaxColumns = 256;
  static constexpr std::size_t kMaxRows = 10'000'000;  ///< As many as a trajectory may have.

  /**
   * Rows of numbers parted by commas, or by blanks where a line has no comma; quotes may enclose a field. Lines that
   * begin with # or % and empty ones are passed over. `names` are the columns' names, parted by commas, instead of
   * those of a first line that holds words alone; where it is empty the first line gives them. Throws Failure with
   * `where` and line.
   */
  [[nodiscard]] static Table parse(std::string_view text, std::string where, const std::string& names);
  /** A file of at most kMaxBytes. */
  [[nodiscard]] static Table read(const std::string& path, const std::string& names);

  /**
   * A quantity by one of several names, parted by blanks: "x px". A name may carry a unit behind an underscore (s, ms,
   * us, ns; m, mm, um; N, mN) by which the column is scaled to SI; of several units the finest is taken. Throws Failure
   * when there are two in one, and with line and column for what is no finite number in it.
   */
  class Column {
   public:
    explicit operator bool() const { return table_ != nullptr; }
    [[nodiscard]] double operator[](std::size_t row) const {
      return scale_ * table_->values_[row * table_->names_.size() + column_];
    }

   private:
    friend class Table;
    const Table* table_ = nullptr;
    std::size_t column_ = 0;
    double scale_ = 1;
  };
  [[nodiscard]] Column find(std::string_view names) const;
  /** Whether there is one, whatever stands in it. */
  [[nodiscard]] bool holds(std::string_view names) const { return static_cast<bool>(lookUp(names)); }
  /** As find(); throws Failure where there is none. */
  [[nodiscard]] Column need(std::string_view names) const;

  /** Leaves out the rows whose column `name` has another number, if it has one of that name; Failure if none is left.
   */
  void keepOnly(std::string_view name, unsigned number);
  /** Leaves out the rows that say nan or inf in a column, if there is one of these names; Failure if none is left. */
  void leaveOutUnknown(std::string_view names);

  [[nodiscard]] std::size_t rows() const { return lines_.size(); }
  /** "FILE, line 7": of a row. */
  [[nodiscard]] std::string at(std::size_t row) const;
  [[nodiscard]] const std::string& where() const { return where_; }

 private:
  void setNames(std::string_view line, std::size_t number, bool given);
  void addRow(std::string_view line, std::size_t number);
  /** As find(), whatever stands in it. */
  [[nodiscard]] Column lookUp(std::string_view names) const;
  /** Whether a row is left. */
  template <class F>
  bool keepRows(F keeps);

  std::string where_;
  bool names_given_ = false;
  std::size_t first_line_ = 0;  ///< Of rows.
  std::vector<std::string> names_;
  std::vector<double> values_;  ///< By row.
  std::vector<std::size_t> lines_;
};

/**
 * Seconds of each row: column t, time or a number over `rate_hz` where there is none. Throws Failure with the line:
 * time that does not rise, a step longer than `max_gap_s` (0: ten times the middle step), or times in another unit.
 */
[[nodiscard]] std::vector<double> readTimes(const Table& table, double rate_hz, double max_gap_s);

/** Throw Failure with the row's line for what no hand survives, or reaches: a wrong column or unit. */
void checkForce(const Table& table, std::size_t row, const hapticd::Vec3& force);
void checkPosition(const Table& table, std::size_t row, const hapticd::Vec3& position);

}  // namespace haptic_bench
