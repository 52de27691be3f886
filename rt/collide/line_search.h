/** @file
 * Places on a line by the gap there.
 */
#pragma once

#include "rt/base/contract.h"

namespace hapticd {

/** Where between lo and hi the gap is least, if it falls and then grows: to 1e-5 of the way. */
template <class Gap>
double leastOf(double lo, double hi, const Gap& gapAt) HD_RT {
  constexpr int kSections = 24;
  constexpr double kGolden = 0.6180339887498949;
  double x = hi - kGolden * (hi - lo), y = lo + kGolden * (hi - lo);
  double at_x = gapAt(x), at_y = gapAt(y);
  for (int i = 0; i < kSections; ++i) {
    if (at_x <= at_y) {
      hi = y;
      y = x;
      at_y = at_x;
      at_x = gapAt(x = hi - kGolden * (hi - lo));
    } else {
      lo = x;
      x = y;
      at_x = at_y;
      at_y = gapAt(y = lo + kGolden * (hi - lo));
    }
  }
  return 0.5 * (lo + hi);
}

/** How far from one place toward another the gap is no more than `most`: to 1e-3 of the way. */
template <class Gap>
double lastOf(double from, double to, double most, const Gap& gapAt) HD_RT {
  constexpr int kHalvings = 12;
  if (gapAt(to) <= most) return to;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (from + to);
    (gapAt(middle) <= most ? from : to) = middle;
  }
  return from;
}

}  // namespace hapticd
