/** @file
 * The surfaces of thesis chapter 4, tessellated.
 */
#pragma once

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** Vertices on the sphere: `stacks` rings of 2 stacks quads, fans at the poles; 4 S (S - 1) triangles. */
[[nodiscard]] Model sphere(double radius, int stacks);

/** The square |x|, |y| <= half at z = 0, facing up. */
[[nodiscard]] Model plane(double half, int cells);

/**
 * A ridge along y on that plane, its apex at x = 0, both flanks at `angle` (thesis figure 4.6). Throws Failure when it
 * is wider than the plane.
 */
[[nodiscard]] Model ridge(double angle, double height, double half);

/** The inside of a sphere about (0, 0, radius) over |x|, |y| <= half, facing up, with edges of about `edge` in x, y. */
[[nodiscard]] Model bowl(double radius, double half, double edge);

}  // namespace haptic_bench
