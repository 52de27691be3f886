/** @file
 * A sweep asked of a vicinity, as far as that reaches.
 */
#pragma once

#include <algorithm>

#include "rt/geometry/earliest.h"
#include "rt/geometry/vicinity.h"

namespace hapticd {

/**
 * Tries the triangles of the sweep's vicinity that may be met before all others. True: the first hit, or that there is
 * none, is known; else the tree must be asked too, which with what has been found answers as if it were asked alone.
 */
template <class Try>
[[nodiscard]] bool sweepVicinity(Sweep& sweep, Earliest& earliest, Try&& tryTriangle) HD_RT {
  if (sweep.vicinity == nullptr) return false;
  const double reach = sweep.radius + sweep.tolerance;
  if (!sweep.vicinity->holds(sweep.a, reach)) return false;
  double known = earliest.time();
  if (!sweep.vicinity->holds(sweep.a + known * sweep.d, reach))
    known = std::min(known, std::max(0.0, sweep.vicinity->room(sweep.a) - reach) / sweep.d.norm());
  const auto take = [&](std::uint32_t t) {
    if (t == sweep.hint) return;  // Has been tried.
    ++sweep.work;
    tryTriangle(t);
  };
  sweep.work += sweep.vicinity->reach(sweep.a, sweep.a + known * sweep.d, reach, sweep.two_sided, take);
  return earliest.time() <= known;
}

}  // namespace hapticd
