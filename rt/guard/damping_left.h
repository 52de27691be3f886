/** @file
 * What damps one device point together: the surface touched, clients' models, drags in free space, the guard's
 * controller. Each damps by a velocity that is late, and what a device bears is borne by their sum.
 */
#pragma once

#include <algorithm>

#include "rt/base/contract.h"

namespace hapticd {

/** All together damp by at most so many times what the device can show: half its stability limit. */
inline constexpr double kMostDampingTogether = 1.5;

/** What a surface or a model may damp by, where the others do by `others`, of a device that can show `can` [N s/m]. */
[[nodiscard]] inline double mostDamping(double can, double others = 0) HD_RT {
  const double left = kMostDampingTogether * can - others;
  return left > 0 ? left : 0.0;  // NaN: 0.
}

/** The same of what nobody set for its damping: no more than the device can show. */
[[nodiscard]] inline double dampingLeft(double can, double others) HD_RT {
  return std::min(mostDamping(can, others), std::max(can, 0.0));
}

}  // namespace hapticd
