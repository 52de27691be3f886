/** @file
 * Where an edge of the scene touches a tool.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rt/body/contact_model.h"
#include "rt/collide/line_search.h"
#include "rt/scene/scene.h"

namespace hapticd {

// What tells whether a normal belongs to an edge, of a box as of a mesh.
inline constexpr double kAside = 0.05;      ///< Sine of the angle by which it may look into a face of the edge,
inline constexpr double kAlong = 0.3;       ///< and along it: farther on it is nearer.
inline constexpr double kOffMantle = 0.02;  ///< Cosine of a cylinder's axis with a normal that is none of its mantle.
/** How far within an edge the tool is asked for, at most a quarter of what the edge is of [m]. */
inline constexpr double kInset = 2e-4;

/** Whether a touch of a cylinder along n, in its frame, is its mantle's, which has discs: not an end's, nor a rim's. */
[[nodiscard]] inline bool isOnMantle(const Shape& cylinder, const Vec3& point, const Vec3& n) HD_RT {
  return std::abs(point.z()) < cylinder.size.y() || !(std::abs(n.z()) > kOffMantle);
}

/** Places on an edge, as parts of its way. */
struct EdgeSpan {
  /** The nearest, and both ends of what touches, which hold the rotation of what lies along. */
  double place[3] = {};
  double least = INFINITY;  ///< Gap at the nearest [m].
  bool near = false;

  /** Whether place j is there, and none before it. */
  [[nodiscard]] bool has(int j) const HD_RT { return near && (j == 0 || place[j] != place[0]); }
};

/**
 * Of an edge of that length where gapAt(t), for t from 0 to 1, is at most `margin`. The gap changes by no more than the
 * way along the edge. Some 10 gaps where the tool lies flat along it, else 60 at most.
 */
template <class Gap>
EdgeSpan touchingSpan(double margin, double length, const Gap& gapAt) HD_RT {
  constexpr int kTries = 4;       // Parts of the edge, from which the nearest place is looked for.
  constexpr double kStep = 1e-3;  // Of the edge,
  constexpr double kFlat = 1e-9;  // and by how much a gap grows there that does not [m].
  constexpr double kPart = 1.0 / kTries;
  EdgeSpan span;
  if (!(gapAt(0.5) <= margin + 0.5 * length)) return span;
  double best = 0;
  for (int j = 0; j <= kTries; ++j) {
    const double t = kPart * j, gap = gapAt(t);
    if (!(gap < span.least)) continue;
    span.least = gap;
    best = t;
  }
  if (!(span.least <= margin + 0.5 * length * kPart)) return span;
  // At an end, or where the tool lies flat along it, nothing is nearer between two places.
  const double before = best > 0 ? gapAt(best - kStep) : INFINITY, behind = best < 1 ? gapAt(best + kStep) : INFINITY;
  if (std::min(before, behind) < span.least ||
      (best > 0 && best < 1 && std::max(before, behind) > span.least + kFlat)) {
    const double near = leastOf(std::max(0.0, best - kPart), std::min(1.0, best + kPart), gapAt);
    const double there = gapAt(near);
    if (there < span.least) {
      best = near;
      span.least = there;
    }
  }
  const double touching = span.least + ContactModel::kLeastReach;
  const double first = lastOf(best, 0, touching, gapAt), last = lastOf(best, 1, touching, gapAt);
  span.near = true;
  span.place[0] = best;
  span.place[1] = first;
  span.place[2] = last;
  return span;
}

}  // namespace hapticd
