/** @file
 * Distances by definition, for comparison: primitives in closed form, meshes triangle by triangle.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "rt/scene/scene.h"

namespace hapticd::test {

inline const Shape kPrimitives[] = {{ShapeKind::kPlane, Vec3::Zero()},
                                    {ShapeKind::kSphere, Vec3(0.7, 0, 0)},
                                    {ShapeKind::kBox, Vec3(0.7, 0.4, 0.2)},
                                    {ShapeKind::kCapsule, Vec3(0.4, 0.6, 0)},
                                    {ShapeKind::kCylinder, Vec3(0.5, 0.4, 0)}};

/** Signed distance of each primitive: negative inside. */
inline double distanceTo(const Shape& s, const Vec3& x) {
  switch (s.kind) {
    case ShapeKind::kPlane:
      return x.z();
    case ShapeKind::kSphere:
      return x.norm() - s.size.x();
    case ShapeKind::kBox: {
      const Vec3 q = x.cwiseAbs() - s.size;
      return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    }
    case ShapeKind::kCapsule:
      return (x - Vec3(0, 0, std::clamp(x.z(), -s.size.y(), s.size.y()))).norm() - s.size.x();
    case ShapeKind::kCylinder: {
      const Eigen::Vector2d q(x.head<2>().norm() - s.size.x(), std::abs(x.z()) - s.size.y());
      return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    }
    default:
      return 0;
  }
}

inline double distanceToSegment(const Vec3& a, const Vec3& b, const Vec3& x) {
  const double t = std::clamp((x - a).dot(b - a) / std::max((b - a).squaredNorm(), 1e-300), 0.0, 1.0);
  return (x - a - t * (b - a)).norm();
}

/** Distance to a triangle: of its plane where x stands over the inside, else of its edges. */
inline double distanceToTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const Vec3 n = (b - a).cross(c - a);
  const bool over = n.dot((b - a).cross(x - a)) >= 0 && n.dot((c - b).cross(x - b)) >= 0 &&
                    n.dot((a - c).cross(x - c)) >= 0 && n.squaredNorm() > 0;
  if (over) return std::abs(n.dot(x - a)) / n.norm();
  return std::min({distanceToSegment(a, b, x), distanceToSegment(b, c, x), distanceToSegment(c, a, x)});
}

inline double distanceTo(const MeshView& mesh, const Vec3& x) {
  double least = HUGE_VAL;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t)
    least = std::min(least, distanceToTriangle(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2), x));
  return least;
}

/** Solid angle of a closed mesh from x over 4 pi (van Oosterom and Strackee, 1983): 1 inside, 0 outside. */
inline double windingNumber(const MeshView& mesh, const Vec3& x) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    const Vec3 a = mesh.vertex(t, 0) - x, b = mesh.vertex(t, 1) - x, c = mesh.vertex(t, 2) - x;
    const double l = a.norm(), m = b.norm(), n = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), l * m * n + a.dot(b) * n + b.dot(c) * l + c.dot(a) * m);
  }
  return sum / (2 * M_PI);
}

inline Vec3 randomPoint(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  return {u(random), u(random), u(random)};
}

}  // namespace hapticd::test
