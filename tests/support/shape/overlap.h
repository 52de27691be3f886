/** @file
 * How far convex shapes reach, and by how much two of them overlap, by looking in all directions.
 */
#pragma once

#include <cmath>
#include <limits>

#include "rt/scene/scene.h"

namespace hapticd::test {

/** A shape's farthest point along d, from its origin; in its frame. A mesh is that of its size's box. */
inline double reachAlong(const Shape& shape, const Vec3& d) {
  const double across = d.head<2>().norm(), along = std::abs(d.z());
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return shape.size.x() * d.norm();
    case ShapeKind::kCapsule:
      return shape.size.y() * along + shape.size.x() * d.norm();
    case ShapeKind::kCylinder:
      return shape.size.y() * along + shape.size.x() * across;
    default:
      return shape.size.dot(d.cwiseAbs());
  }
}

/** The way along n, unit, on which b leaves a [m]. */
inline double overlapAlong(const Vec3& n, const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  return reachAlong(a, X_WA.q.conjugate() * n) + reachAlong(b, X_WB.q.conjugate() * n) - n.dot(X_WB.p - X_WA.p);
}

/** The least way that parts them, in any direction, within some hundredths of it; negative: apart [m]. */
inline double overlapOf(const Shape& a, const Pose& X_WA, const Shape& b, const Pose& X_WB) {
  double least = std::numeric_limits<double>::infinity();
  Vec3 best = Vec3::UnitX();
  const auto look = [&](const Vec3& at) {
    const Vec3 n = at.normalized();
    if (const double now = overlapAlong(n, a, X_WA, b, X_WB); now < least) {
      least = now;
      best = n;
    }
  };
  const Mat3 of_a = X_WA.q.toRotationMatrix(), of_b = X_WB.q.toRotationMatrix();
  for (int i = 0; i < 9; ++i) {  // What two edges have between them is narrow, and known.
    const Vec3 across = of_a.col(i / 3).cross(of_b.col(i % 3));
    if (across.norm() < 1e-6) continue;
    look(across);
    look(-across);
  }
  for (const Mat3& axes : {of_a, of_b}) {
    for (int i = 0; i < 3; ++i) {
      look(axes.col(i));
      look(-axes.col(i));
    }
  }
  constexpr int kDirections = 1000;
  for (int i = 0; i < kDirections; ++i) {  // Evenly, on a spiral.
    const double z = 1 - (2.0 * i + 1) / kDirections, angle = EIGEN_PI * (3 - std::sqrt(5.0)) * i;
    const double r = std::sqrt(1 - z * z);
    look({r * std::cos(angle), r * std::sin(angle), z});
  }
  const auto refine = [&](const auto& around) {
    for (double step = 0.1; step > 1e-5;) {
      const double before = least;
      around(Vec3(best), step);
      if (!(least < before)) step /= 2;
    }
  };
  const auto everywhere = [&](const Vec3& from, double step) {
    for (int i = 0; i < 27; ++i) look(from + step * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
  };
  refine(everywhere);
  // Straight across an axis there may be a narrow valley: that is walked along.
  for (const Mat3& axes : {of_a, of_b}) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 along = axes.col(i), across = axes.col((i + 1) % 3), up = axes.col((i + 2) % 3);
      constexpr int kRound = 360;
      for (int k = 0; k < kRound; ++k) {
        const double angle = 2 * EIGEN_PI * k / kRound;
        look(std::cos(angle) * across + std::sin(angle) * up);
      }
      refine([&](const Vec3& from, double step) {
        const Vec3 aside = along.cross(from);
        look(from + step * aside);
        look(from - step * aside);
      });
    }
  }
  refine(everywhere);
  return least;
}

}  // namespace hapticd::test
