/** @file
 * A motion from a CSV file: where a hand wants to be, over time.
 */
#pragma once

#include <array>
#include <string>
#include <vector>

namespace hapticctl {

/** Rows in order of time, at least two; time begins at 0. */
class Motion {
 public:
  struct Row {
    double t_s;
    std::array<double, 3> p;
  };

  /**
   * Reads columns t (or time) [s] and x, y, z (or px, py, pz) [m] by the names in the first line, which may carry a
   * unit: t_s, t_ms, x_m, x_mm; without names they are t,x,y,z, and perhaps a quaternion. Others are passed over, so
   * that a recording of hapticctl monitor --csv is a motion too. A motion stays within 10 m and 1e7 s. Throws Failure
   * naming file, line and column.
   */
  [[nodiscard]] static Motion read(const std::string& path);

  [[nodiscard]] double duration() const { return rows_.back().t_s; }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  /** On straight lines between the rows; the ends hold. */
  [[nodiscard]] std::array<double, 3> at(double t_s) const;

 private:
  std::vector<Row> rows_;
};

}  // namespace hapticctl
