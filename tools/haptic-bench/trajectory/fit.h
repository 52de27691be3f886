/** @file
 * Where an out-trajectory does not fit the model: a corner that is narrower than the ball keeps it off the point that
 * it should touch, and in a thin place the hand is pressed through the middle.
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

/**
 * Says on the standard error at how many samples the hand is pressed in so far that another side of the model is nearer
 * to it. The nearest point does not feel the truth there; a proxy does on a plate, but slides around what is round.
 */
void tellOfThinPlaces(const Trajectory& in, const std::vector<SurfaceSample>& out, const Model& model,
                      const std::string& what);

}  // namespace haptic_bench
