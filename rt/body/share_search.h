/** @file
 * How much of the velocities may be kept that would bring more energy than the books allow.
 */
#pragma once

#include <cmath>

#include "rt/base/math.h"

namespace hapticd {

/**
 * Halves the share until the books allow it, then looks for the greatest that they do: first as if energy went
 * with its square, then with the springs' part, which goes with the share. Ask share(), tell next() what it came to,
 * until next() says no.
 *
 * At most kMostTries + kRefinements + 1 shares are asked for. Servo-safe; one thread.
 */
class ShareSearch {
 public:
  static constexpr int kMostTries = 6;     ///< Each half of the one before; then a full stop.
  static constexpr int kRefinements = 3;   ///< Of the share that these found.
  static constexpr double kInside = 1e-3;  ///< Each stays off the limit by this part of the way to it.

  /** `first` is asked for first and is the most. */
  explicit ShareSearch(double first) HD_RT : share_(first) {}

  /** 0 to `first`. */
  [[nodiscard]] double share() const HD_RT { return share_; }
  /** Nothing was allowed: share() is 0, whatever it comes to. */
  [[nodiscard]] bool stopped() const HD_RT { return stopped_; }

  /** share() would bring `excess` more than is allowed [J]. False: it is the answer. */
  bool next(double excess) HD_RT {
    const bool allowed = excess <= 0;
    if (stopped_ || settled_ || (allowed && tries_ == 0)) return false;
    Tried& side = allowed ? low_ : high_;
    before_ = side;
    side = {share_, excess};
    if (!allowed && low_.share == 0) {
      stopped_ = ++tries_ == kMostTries;
      share_ = stopped_ ? 0 : 0.5 * share_;
      return true;
    }
    if (refined_++ == kRefinements) {
      if (allowed) return false;
      share_ = low_.share;
      settled_ = true;
      return true;
    }
    const double open = high_.share - low_.share;
    const double way = refined_ == 1 ? squareRoot() : parabolaRoot(open);
    share_ = low_.share + (way > 0 && way <= open ? (1 - kInside) * way : 0.5 * open);  // also if it is not a number
    return true;
  }

 private:
  struct Tried {
    double share = 0;
    double excess = 0;
  };
  /** From the lower share to where the excess is zero, if it goes with the square of the share. */
  [[nodiscard]] double squareRoot() const HD_RT {
    const double low = low_.share * low_.share;
    const double high = high_.share * high_.share;
    return std::sqrt(low + low_.excess / (low_.excess - high_.excess) * (high - low)) - low_.share;
  }
  /** The same for the parabola through the three shares tried last: springs add what goes with the share itself. */
  [[nodiscard]] double parabolaRoot(double open) const HD_RT {
    const double rise = (high_.excess - low_.excess) / open;
    const double rise_before = (before_.excess - low_.excess) / (before_.share - low_.share);
    const double bend = (rise_before - rise) / (before_.share - high_.share);
    const double start = rise - bend * open;
    return -2 * low_.excess / (start + std::sqrt(start * start - 4 * bend * low_.excess));
  }

  double share_;
  Tried low_, high_;  ///< The greatest share allowed, and the least that is not.
  Tried before_;      ///< What the newest of them replaced.
  int tries_ = 0;
  int refined_ = 0;
  bool stopped_ = false;
  bool settled_ = false;
};

}  // namespace hapticd
