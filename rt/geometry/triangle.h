/** @file
 * The nearest point of a triangle. Servo-safe.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/geometry/feature.h"

namespace hapticd {

/** A triangle's corners, counter-clockwise seen from outside. */
struct Corners {
  Vec3 a, b, c;

  /** Twice the area long. */
  [[nodiscard]] Vec3 normal() const HD_RT { return (b - a).cross(c - a); }
};

/** A point of a triangle and what it belongs to. */
struct TriangleFoot {
  Vec3 point = Vec3::Zero();
  FeatureKind kind = FeatureKind::kFace;
  std::uint32_t corner = 0;  ///< Which edge (01, 12, 20) or vertex.
};

/**
 * The point of the triangle nearest to x (Ericson, Real-Time Collision Detection, 2005, 5.1.5). A triangle without area
 * is its edges.
 */
[[nodiscard]] TriangleFoot nearestOnTriangle(const Corners& triangle, const Vec3& x) HD_RT;

}  // namespace hapticd
