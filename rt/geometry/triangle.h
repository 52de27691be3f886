/** @file
 * A triangle by itself: its corners, its nearest point. Servo-safe.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/geometry/feature.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** As areaVector(), digit by digit: errors of products are taken along (Dekker 1971). */
[[nodiscard, gnu::cold]] Vec3 areaVectorOfNeedle(const Vec3& one, const Vec3& other) HD_RT;

inline constexpr double kNeedle2 = 0x1p-20;  ///< Squared: how thin a needle is for its length, at most.

/**
 * one x other, twice the area of the triangle between two of its edges; its direction is exact to rounding also for a
 * needle, whose edges nearly have one direction and whose plane a plain cross product tips by more than a skin.
 */
[[nodiscard, gnu::always_inline]] inline Vec3 areaVector(const Vec3& one, const Vec3& other) HD_RT {
  Vec3 n = one.cross(other);
  const bool needle = n.squaredNorm() < kNeedle2 * (one.squaredNorm() * other.squaredNorm());
  if (needle) [[unlikely]]
    return areaVectorOfNeedle(one, other);
  return n;
}

/** A triangle's corners, counter-clockwise seen from outside. */
struct Corners {
  Vec3 a, b, c;

  /** Twice the area long. */
  [[nodiscard, gnu::always_inline]] inline Vec3 normal() const HD_RT { return areaVector(b - a, c - a); }
};

inline Corners cornersOf(const MeshView& mesh, std::uint32_t t) HD_RT {
  return {mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)};
}

/** Which corner of the triangle that vertex of it is. */
inline std::uint32_t cornerOf(const MeshView& mesh, std::uint32_t triangle, std::uint32_t vertex) HD_RT {
  const MeshView::Index3& v = mesh.triangles[triangle];
  return v[0] == vertex ? 0 : (v[1] == vertex ? 1 : 2);
}

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
