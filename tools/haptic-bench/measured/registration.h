/** @file
 * Where a mesh lies in the frame of what was measured on it.
 */
#pragma once

#include <vector>

#include "rt/base/math.h"
#include "tools/haptic-bench/model/tree_nearest.h"

namespace haptic_bench {

using hapticd::Pose;

struct Registration {
  Pose X_MO;         ///< Takes measured points to the mesh's frame.
  double rms = 0;    ///< Of the points' distances from the surface, those left out aside [m].
  int left_out = 0;  ///< Points further off than three times the middle distance.
  int rounds = 0;
  bool settled = false;  ///< Else the rounds were too few.
  int freedoms = 0;      ///< Of six, those that the points determine: a plane leaves three, a sphere three.
  double most = 0;       ///< Three quarters of all points lie nearer to the surface than this [m].

  double guess_most = 0;    ///< Where another guess than the first led here: `most` where that one led [m].
  bool guess_lost = false;  ///< Another guess than the first led here.
  int as_near = 0;          ///< Other places found where the points lie as near; with all six freedoms determined.
};

/**
 * Finds the pose in which the points lie `offset` outside the surface (a ball's centres): point-to-plane ICP (Chen and
 * Medioni, 1992), each step by the singular values of the linearised problem; directions in which the surface slides
 * along itself keep the first guess. Where the choice of points left out and of nearest triangles leads round in a ring
 * the steps fade, and the place is known to half the rms. Throws Failure for fewer than 6 points.
 */
[[nodiscard]] Registration registerPoints(const TreeNearest& surface, const std::vector<Vec3>& points, double offset,
                                          const Pose& first_guess, int max_rounds = 200);

}  // namespace haptic_bench
