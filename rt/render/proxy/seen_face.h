/** @file
 * A triangle of a mesh, and a point seen along its normal: beyond which edge it lies, and what rises or falls there. Of
 * proxy*.cc only.
 */
#pragma once

#include <cmath>
#include <cstdint>

#include "rt/geometry/half_spaces.h"
#include "rt/geometry/triangle.h"

namespace hapticd {

inline constexpr double kFlat = 1e-6;     // Of the squared sine: two faces so much in one plane have no hollow.
inline constexpr double kTan2 = 1.0 / 3;  // Squared tangent of half the turn at most.

/** The point nearest to x on both planes, if both push it there. */
inline bool nearestInHollow(const HalfSpace& one, const HalfSpace& other, const Vec3& x, Vec3& nearest) HD_RT {
  const double cosine = one.normal.dot(other.normal), sine2 = 1 - cosine * cosine;
  const double to_one = -one.height(x), to_other = -other.height(x);
  const double push = to_one - cosine * to_other, push_other = to_other - cosine * to_one;
  if (!(sine2 > kFlat && push > 0 && push_other > 0)) return false;
  nearest = x + (push / sine2) * one.normal + (push_other / sine2) * other.normal;
  return true;
}

/** Of `triangle` the corner that its neighbour does not have. */
inline Vec3 oppositeCorner(const MeshView& mesh, std::uint32_t triangle, std::uint32_t neighbour) HD_RT {
  const auto& across = mesh.neighbours[triangle];
  return mesh.vertex(triangle, across[0] == neighbour ? 2 : (across[1] == neighbour ? 0 : 1));
}

/** Of the triangle of these two edges the square of twice its area (Lagrange's identity). */
inline double area2(const Vec3& one, const Vec3& other) HD_RT {
  const double common = one.dot(other);
  return one.squaredNorm() * other.squaredNorm() - common * common;
}

/** A triangle of a mesh, and where some point is, seen along its normal. */
struct SeenFace {
  const MeshView& mesh;
  std::uint32_t triangle;
  Vec3 v[3];
  Vec3 up;            ///< Twice the area long,
  double up2 = 0;     ///< and its square.
  Vec3 along[3];      ///< From corner to corner.
  double in[3] = {};  ///< Of the point, beyond each edge: times its length and up's.

  SeenFace(const MeshView& m, std::uint32_t t) HD_RT : mesh(m), triangle(t) {
    for (int k = 0; k < 3; ++k) v[k] = mesh.vertex(t, k);
    for (int k = 0; k < 3; ++k) along[k] = v[(k + 1) % 3] - v[k];
    up = along[0].cross(-along[2]);
    up2 = up.squaredNorm();
  }
  /** Too thin for its plane to be told from products of lengths. */
  [[nodiscard]] bool isNeedle() const HD_RT {
    return !(up2 > kNeedle2 * (along[0].squaredNorm() * along[2].squaredNorm()));
  }
  void seek(const Vec3& x) HD_RT {
    for (int k = 0; k < 3; ++k) in[k] = along[k].cross(x - v[k]).dot(up);
  }
  /** The edge beyond which the point lies farthest; -1 if it is over the face. */
  [[nodiscard]] int out() const HD_RT {
    int farthest = -1;
    double least = 0;
    for (int k = 0; k < 3; ++k) {
      if (in[k] >= least) continue;
      farthest = k;
      least = in[k];
    }
    return farthest;
  }
  /** Whether the point is so near to edge k that a plane through it, however it turns, may be nearer than `near`. */
  [[nodiscard]] bool isNear(int k, double near) const HD_RT {
    return in[k] * in[k] <= kTan2 * near * near * up2 * along[k].squaredNorm();
  }
  /** Of the neighbour over edge k the third corner, from corner k. False if there is none. */
  [[nodiscard]] bool beyond(int k, Vec3& opposite) const HD_RT {
    const std::uint32_t across = mesh.neighbours[triangle][k];
    if (across == HD_NO_INDEX) return false;
    opposite = oppositeCorner(mesh, across, triangle) - v[k];
    return true;
  }
};

/**
 * The edge of a face over which a neighbour rises that a ball touches with its centre at x, above the face, the deepest
 * of several: -1 if there is none. The ball touches it before its foot on the face comes to the edge.
 */
inline int steeperEdge(const SeenFace& f, const Vec3& x, double radius) HD_RT {
  int steepest = -1;
  double least = radius * radius;  // Height above its plane, squared with its sign.
  for (int k = 0; k < 3; ++k) {
    Vec3 opposite;
    if (!f.isNear(k, radius) || !f.beyond(k, opposite) || !(f.up.dot(opposite) > 0)) continue;
    const double height = opposite.dot(f.along[k].cross(x - f.v[k]));
    const double area = area2(opposite, f.along[k]), squared = height * std::abs(height);
    if (!(squared < least * area)) continue;
    steepest = k;
    least = squared / area;
  }
  return steepest;
}

}  // namespace hapticd
