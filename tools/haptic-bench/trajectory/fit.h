/** @file
 * Where a ball fits: a corner that is narrower than it keeps it off the point that it should touch.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

/**
 * Of an out-trajectory that was pressed in: the samples at which the ball's centre is nearer to the mesh than its
 * radius are not judged, for no surface pushes it there. What the normal is tilted against the facet below, and what
 * the point lies off it, is not held against them. A point fits everywhere. Throws Failure with `what` if no sample is
 * left.
 */
void judgeWhereItFits(Trajectory& in, const std::vector<SurfaceSample>& out, const Model& model, double radius,
                      const std::string& what);

}  // namespace haptic_bench
