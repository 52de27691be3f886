/** @file
 * How far things are apart, and all edges of a box: what oracles of tools that lie on something are made of.
 */
#pragma once

#include <cmath>
#include <limits>

#include "rt/geometry/nearest/nearest.h"

namespace hapticd::test {

/** From the shape's surface to x, in its frame, negative inside; `reach` where nothing is nearer. */
inline double signedGap(const Shape& shape, const Vec3& x, double reach = std::numeric_limits<double>::infinity()) {
  NearestQuery query;
  query.x = x;
  query.reach = reach;
  query.limit = 1'000'000;
  Nearest nearest;
  if (nearestOnShape(shape, query, nearest) != NearestResult::kFound) return reach;
  return (nearest.isInside(x) ? -1 : 1) * std::sqrt(nearest.squared_distance);
}

/** Calls visit(x) for the point at t, from -1 to 1, of each edge of a box. */
template <class Visit>
void onBoxEdges(const Vec3& half, double t, const Visit& visit) {
  for (int i = 0; i < 12; ++i) {
    Vec3 x = half;
    x[i / 4] *= t;
    x[(i / 4 + 1) % 3] *= (i & 1) != 0 ? 1 : -1;
    x[(i / 4 + 2) % 3] *= (i & 2) != 0 ? 1 : -1;
    visit(x);
  }
}

}  // namespace hapticd::test
