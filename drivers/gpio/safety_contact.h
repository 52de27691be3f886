/** @file
 * A safety contact with a debounce that errs toward open: an emergency stop that must be closed, a dead-man switch that
 * must be held.
 */
#pragma once

#include <cstdint>
#include <limits>

#include "rt/base/contract.h"

namespace hapticd {

/**
 * Counts as open
 *  - as soon as it has been open for the debounce time, or has opened twice within it (a loose wire);
 *  - until it has been closed without a change for kSettle_ns.
 * So one glitch shorter than the debounce is passed over, and nothing else. Fed by edges and by looks at the level, so
 * that an edge that was lost costs no more than the time to the next look.
 */
class SafetyContact {
 public:
  static constexpr std::int64_t kSettle_ns = 20'000'000;
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  SafetyContact(std::int64_t debounce_ns, bool closed) noexcept
      : debounce_ns_(debounce_ns), open_(!closed), level_(closed) {}

  /** The level is `closed` at `now_ns`, by an edge or by a look. */
  void see(bool closed, std::int64_t now_ns) HD_RT {
    pass(now_ns);  // First, at the level that was: an opening that is over counts for all its time.
    if (closed != level_) {
      level_ = closed;
      changed_ns_ = now_ns;
      if (!closed && !open_) {
        open_ = suspected_ || debounce_ns_ <= 0;
        if (!suspected_) suspected_ns_ = now_ns;
        suspected_ = true;
      }
    }
    pass(now_ns);
  }
  /** Time passes. */
  void pass(std::int64_t now_ns) HD_RT {
    if (open_) {
      suspected_ = false;
      open_ = !level_ || now_ns - changed_ns_ < kSettle_ns;
    } else if (suspected_ && now_ns - suspected_ns_ >= debounce_ns_) {
      suspected_ = false;
      open_ = !level_;
    }
  }
  [[nodiscard]] bool open() const HD_RT { return open_; }
  /** When pass() may change something; kNever: not before the next edge. */
  [[nodiscard]] std::int64_t due() const HD_RT {
    if (open_) return level_ ? changed_ns_ + kSettle_ns : kNever;
    return suspected_ ? suspected_ns_ + debounce_ns_ : kNever;
  }

 private:
  std::int64_t debounce_ns_;
  bool open_;
  bool level_;  ///< Closed, as last seen.
  std::int64_t changed_ns_ = 0;
  bool suspected_ = false;  ///< Has opened, less than the debounce time ago.
  std::int64_t suspected_ns_ = 0;
};

}  // namespace hapticd
