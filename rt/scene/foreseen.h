/** @file
 * Whether a pose brings something where its velocity would have brought it.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/** A step of something in a ball. */
struct Step {
  Pose before, now;
  Pose foreseen;     ///< Where its velocity takes it from `before`.
  Vec3 middle_O;     ///< Of the ball.
  double lever = 0;  ///< Its radius [m].
};

/**
 * Whether all of it comes within `aside` [m] of its way to the foreseen pose, or of a part of that way: who is late
 * foresees more than what comes. Exact up to the chords of arcs.
 */
[[nodiscard]] bool isForeseen(const Step& step, double aside) HD_RT;

}  // namespace hapticd
