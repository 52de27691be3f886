/** @file
 * A sweep asked of a vicinity, as far as that reaches.
 */
#pragma once

#include <algorithm>
#include <limits>

#include "rt/geometry/sweep/below.h"
#include "rt/geometry/sweep/earliest.h"
#include "rt/geometry/tree/vicinity.h"

namespace hapticd {

inline constexpr double kGrazed = 0x1p-29;  ///< Of the radius: twice what the test of a ball allows.

/**
 * Tries the triangles of the sweep's vicinity that may be met, but those below it, before all others. True: the first
 * hit, or that there is none, is known; else the tree must be asked too, which with what has been found answers as if
 * it were asked alone.
 */
template <class Try>
[[nodiscard]] bool sweepVicinity(const MeshView& mesh, Sweep& sweep, const BelowWay& below, Earliest& earliest,
                                 Try&& tryTriangle) HD_RT {
  if (sweep.vicinity == nullptr) return false;
  const double reach = sweep.radius + sweep.tolerance;
  if (!sweep.vicinity->holds(sweep.a, reach)) return false;
  double known = earliest.time();
  if (!sweep.vicinity->holds(sweep.a + known * sweep.d, reach))
    known = std::min(known, std::max(0.0, sweep.vicinity->room(sweep.a) - reach) / sweep.d.norm());
  // Who is behind a triangle by the tolerance meets it still, and that may be more than all that is kept.
  const double behind =
      sweep.two_sided ? std::numeric_limits<double>::infinity() : sweep.tolerance + kGrazed * sweep.radius;
  Vicinity::Reached reached;
  sweep.vicinity->reach(sweep.a, sweep.a + known * sweep.d, reach, behind, reached);
  sweep.work += reached.blocks;
  std::uint32_t left = 0;
  for (std::uint32_t i = 0; i < reached.count; ++i) {
    const std::uint32_t t = reached.triangle[i];
    if (t == sweep.hint) continue;  // Has been tried.
    ++sweep.work;
    reached.triangle[left] = t;
    left += below.has(mesh.corners[t]) ? 0 : 1;
  }
  for (std::uint32_t i = 0; i < left; ++i) tryTriangle(reached.triangle[i]);
  return earliest.time() <= known;
}

}  // namespace hapticd
