/** @file
 * A smooth curve through a few points, and where it is nearest.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd {

inline constexpr int kChordsPerSpan = 8;  ///< What lies between two points is so many straight pieces.

/**
 * The curve is Catmull and Rom's: in each point it goes the way from the one before to the one after, at the ends
 * straight on. Two points make a line, and where the last is the first the curve is closed and smooth there too.
 */
struct PathPlace {
  Vec3 point = Vec3::Zero();    ///< Of the curve [m].
  Vec3 tangent = Vec3::Zero();  ///< Unit, or zero where all points are one.
};

/** The point nearest to x, if it is nearer than `reach` [m]; of several one, the same each time. */
[[nodiscard]] bool nearestOnPath(const EffectParameters& path, const Vec3& x, double reach, PathPlace& place) HD_RT;

/** The control points of the span from point i to the next, as Bezier has them: the curve is within their hull. */
void spanOfPath(const EffectParameters& path, std::uint32_t i, Vec3 (&control)[4]) HD_RT;

}  // namespace hapticd
