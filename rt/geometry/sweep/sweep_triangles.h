/** @file
 * The search that all sweeps against a mesh share: the hint, the vicinity, then the tree.
 */
#pragma once

#include "rt/geometry/sweep/below.h"
#include "rt/geometry/sweep/earliest.h"
#include "rt/geometry/sweep/sweep_vicinity.h"
#include "rt/geometry/tree/box_queries.h"
#include "rt/geometry/tree/tree_walk.h"

namespace hapticd {

/** The first hit of those that `tryTriangle(triangle, earliest)` makes. Servo-safe if that is; bounded by sweep.limit.
 */
template <class Try>
[[nodiscard]] SweepResult sweepTriangles(const MeshView& mesh, Sweep& sweep, SweepHit& hit, Try&& tryTriangle) HD_RT {
  Earliest earliest(hit);
  const BelowWay below(sweep);
  const auto tryOne = [&](std::uint32_t t) {
    if (!below.has(mesh.corners[t])) tryTriangle(t, earliest);
  };
  if (sweep.hint < mesh.triangle_count) {
    ++sweep.work;
    tryOne(sweep.hint);
  }
  if (sweepVicinity(mesh, sweep, below, earliest, [&](std::uint32_t t) { tryTriangle(t, earliest); }))
    return earliest.found() ? SweepResult::kHit : SweepResult::kNone;
  const SweptBoxes boxes(sweep);
  const BoxTests& tests = boxTests();
  const bool finished = walkTree(
      mesh, {sweep.work, sweep.limit},
      [&](const hd_bvh_node& node, float* key) { return boxes.look(tests, node, hit.t, key); },
      [&] { return roundedUp(hit.t); },
      [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t t = first; t < first + count; ++t) tryOne(t);
      });
  if (!finished) return SweepResult::kExhausted;
  return earliest.found() ? SweepResult::kHit : SweepResult::kNone;
}

}  // namespace hapticd
