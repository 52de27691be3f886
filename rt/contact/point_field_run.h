/** @file
 * What one query of the point field detector carries from step to step. Included by its sources alone.
 */
#pragma once

#include "rt/contact/field_query.h"
#include "rt/contact/point_field.h"

namespace hapticd {

struct PointFieldDetector::Run : FieldQuery {
  Run(const DetectorQuery& q, double margin, DetectorReport& r) HD_RT : FieldQuery(q, margin),
                                                                        report(r),
                                                                        limit(q.budget.units) {}

  void drop(const hd_volume_patch& p) const HD_RT {
    ++report.dropped;
    report.dropped_area += p.area;
  }

  [[nodiscard]] bool timed() const HD_RT { return query.budget.clock != nullptr && query.budget.deadline_ns != 0; }
  /** Whether the deadline has passed, asked every few hundred units. */
  [[nodiscard]] bool late(std::uint32_t work) HD_RT {
    constexpr std::uint32_t kUnits = 256;
    if (is_late || !timed() || work < checked) return is_late;
    checked = work + kUnits;
    is_late = query.budget.clock->now() >= query.budget.deadline_ns;
    return is_late;
  }

  DetectorReport& report;
  std::uint32_t limit;        ///< Units; 0: none.
  std::uint32_t wanted = 0;   ///< Blocks that may touch.
  std::uint32_t patches = 0;  ///< Patches that may.
  std::uint32_t order = 0;    ///< Groups that may.
  std::uint32_t checked = 0;  ///< Work at which the clock is read next.
  bool is_late = false;
  bool touched[kMaxTouchGroups];
  float worth[kMaxTouchGroups];  ///< How many patches each of a group stands for.
};

}  // namespace hapticd
