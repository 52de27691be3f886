/** @file
 * The solids of haptic-bench collide. Given in mm by their formulas, made in m.
 */
#pragma once

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** 69,620 triangles: an icosahedron's faces divided 59 times, blown up to 50 mm with bumps of three sizes. */
[[nodiscard]] Model bumpyBall();

/** 20,000 triangles: radius 10 mm, its tip at the origin, 60 mm up along z. */
[[nodiscard]] Model peg();

/** 17,600 triangles: 80 x 80 x 20 mm below z = 0, with a hole of 10.1 mm along z. */
[[nodiscard]] Model plateWithHole();

/** 66,960 triangles: one half of a broken block of 60 x 60 mm, 20 mm thick; `upper` fits onto the other at z = 0. */
[[nodiscard]] Model fractureHalf(bool upper);

}  // namespace haptic_bench
