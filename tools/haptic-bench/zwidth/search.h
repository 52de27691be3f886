/** @file
 * The largest stable stiffness, by bisection.
 */
#pragma once

#include "tools/haptic-bench/zwidth/loop.h"
#include "tools/haptic-bench/zwidth/tap.h"

namespace haptic_bench::zwidth {

inline constexpr double kPrecision = 0.01;  ///< Of the stiffness found.
inline constexpr double kStiffest = 1e7;    ///< Where the search ends [N/m].

/** The stiffest wall below which all that were tried are stable. */
struct Limit {
  double stiffness = 0;  ///< [N/m]; 0: none is stable down to 10 N/m.
  Tap at;                ///< The trial there.
};

/**
 * Goes up from half of `guess` [N/m] by quarters until a wall is unstable, then bisects. A stiffer wall that happens to
 * be stable again does not count.
 */
[[nodiscard]] Limit largestStable(const Loop& loop, double damping, double guess);

}  // namespace haptic_bench::zwidth
