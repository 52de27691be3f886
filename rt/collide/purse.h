/** @file
 * What the points of a tool may cost.
 */
#pragma once

#include <algorithm>
#include <cstdint>

#include "rt/collide/scene_contacts.h"

namespace hapticd {

/** What points may cost. */
struct SceneContacts::Purse {
  static constexpr std::uint32_t kClockEvery = 256;  ///< Units between two looks at the clock; some 10 ns each.

  Purse(const WorkBudget& b, DetectorReport& r) HD_RT : budget(b), report(r) {}
  /** Leaves so many sixteenths of what is in it for others. */
  void spare(std::uint32_t parts) HD_RT {
    budget.units -= static_cast<std::uint32_t>(std::uint64_t{parts} * budget.units / 16);
    if (timed()) budget.deadline_ns -= parts * std::max<std::int64_t>(0, budget.deadline_ns - budget.clock->now()) / 16;
  }
  [[nodiscard]] bool timed() const HD_RT { return budget.clock != nullptr && budget.deadline_ns != 0; }
  [[nodiscard]] bool empty() HD_RT {
    over = over || left() == 0;
    if (over || !timed() || report.work < next_look) return over;
    next_look = report.work + kClockEvery;
    over = budget.clock->now() >= budget.deadline_ns;
    return over;
  }
  /** Of units, for one point. */
  [[nodiscard]] std::uint32_t left() const HD_RT {
    if (budget.units == 0) return kWorkOfOne;
    return budget.units > report.work ? std::min(kWorkOfOne, budget.units - report.work) : 0;
  }

  WorkBudget budget;
  DetectorReport& report;
  std::uint32_t next_look = 0;
  bool over = false;
};

}  // namespace hapticd
