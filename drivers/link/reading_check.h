/** @file
 * Which readings of a device are believed, and for how long: a hand does not jump. Pure, real-time safe.
 */
#pragma once

#include <algorithm>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/**
 * A reading is believed where the device can be there at all, no further from the last one that was believed than a
 * hand gets. A few that are not are dropped; so many in a row mean that something is broken, a slipped encoder: a
 * device error, after which the next place that can be is the new truth.
 *
 * A hand goes on while nothing is heard; while what is heard is not believed it gets no more time for a jump, but for
 * the 1 to 5 ms that readings may be apart. One thread.
 */
class ReadingCheck {
 public:
  enum class Verdict : std::uint8_t { kBelieved, kDropped, kBroken };

  /** `most_per_ms`: how far a hand gets, in whatever the device tells. */
  constexpr ReadingCheck(double most_per_ms, int bad_in_a_row) noexcept
      : most_per_ms_(most_per_ms), bad_in_a_row_(bad_in_a_row) {}

  /** What comes next is the first. */
  void forget() HD_RT { known_ = false, bad_ = 0; }
  /** `possible`: it can be there. `moved`: how far that is from the last one believed, if there is one. */
  [[nodiscard]] Verdict judge(bool possible, double moved, std::int64_t now_ns) HD_RT {
    const double most = most_per_ms_ * handTime_ms(now_ns);
    if (possible && (!known_ || moved <= most)) {
      known_ = true;
      bad_ = 0;
      believed_ns_ = now_ns;
      return Verdict::kBelieved;
    }
    if (++bad_ < bad_in_a_row_) return Verdict::kDropped;
    forget();
    return Verdict::kBroken;
  }
  /** Whether a force may be computed from the last reading that was believed: one no older than `most_ns`. */
  [[nodiscard]] bool trusted(std::int64_t now_ns, std::int64_t most_ns) const HD_RT {
    return known_ && now_ns - believed_ns_ <= most_ns;
  }
  /** Readings in a row that were not believed. */
  [[nodiscard]] int bad() const HD_RT { return bad_; }

 private:
  [[nodiscard]] double handTime_ms(std::int64_t now_ns) HD_RT {
    const double since_ms = static_cast<double>(now_ns - believed_ns_) * 1e-6;
    if (bad_ == 0) silent_ms_ = since_ms;
    return std::max(std::clamp(since_ms, 1.0, 5.0), silent_ms_);
  }

  double most_per_ms_;
  int bad_in_a_row_;
  bool known_ = false;
  int bad_ = 0;
  std::int64_t believed_ns_ = 0;
  double silent_ms_ = 0;  ///< From the last reading that was believed to the one after it.
};

}  // namespace hapticd
