#include "tools/haptic-bench/zwidth/search.h"

#include <algorithm>
#include <cmath>

namespace haptic_bench::zwidth {

Limit largestStable(const Loop& loop, double damping, double guess) {
  constexpr double kStride = 1.25, kSoftest = 10;
  Limit limit;
  const auto stable = [&](double stiffness) {
    const Tap trial = tap(loop, {stiffness, damping});
    if (trial.stable) limit = {stiffness, trial};
    return trial.stable;
  };
  double high = std::clamp(guess / 2, kSoftest, kStiffest);
  while (!stable(high)) {
    if (high == kSoftest) return limit;
    high = std::max(high / kStride, kSoftest);
  }
  for (high *= kStride; high < kStiffest && stable(high);) high *= kStride;
  while (high > limit.stiffness * (1 + kPrecision)) {
    const double middle = std::sqrt(limit.stiffness * high);
    if (!stable(middle)) high = middle;
  }
  return limit;
}

}  // namespace haptic_bench::zwidth
