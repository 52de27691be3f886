/** @file
 * Registration that does not hang on one first guess.
 */
#pragma once

#include <vector>

#include "tools/haptic-bench/measured/registration.h"

namespace haptic_bench {

/**
 * registerPoints() from the first guess and, in a few rounds with some of the points, from others: shifted by a quarter
 * of the points' extent; and turned to each of the 24 places of a cube, about the points' middle where that is and
 * where it is the middle of `box`, the mesh's. One of these is taken where it leads to less than half of `most`. Throws
 * Failure as registerPoints(), and where the first guess does not settle and none of the others leads there.
 */
[[nodiscard]] Registration registerFromSeveral(const TreeNearest& surface, const Eigen::AlignedBox3d& box,
                                               const std::vector<Vec3>& points, double offset, const Pose& first_guess);

}  // namespace haptic_bench
