/** @file
 * The surface point nearest to x, by trying every triangle: the oracle of accuracy.
 */
#pragma once

#include <cmath>
#include <vector>

#include "rt/scene/mesh_view.h"

namespace hapticd::test {

inline Vec3 nearestOnSegment(const Vec3& a, const Vec3& b, const Vec3& x) {
  return a + std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0) * (b - a);
}

/** All triangles of a mesh, each with a ball about it that lets most of them be passed over. */
class BruteNearest {
 public:
  explicit BruteNearest(const MeshView& mesh) {
    for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
      Face f{{mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)}};
      f.normal = (f.v[1] - f.v[0]).cross(f.v[2] - f.v[0]).normalized();
      f.center = (f.v[0] + f.v[1] + f.v[2]) / 3;
      for (const Vec3& v : f.v) f.radius = std::max(f.radius, (v - f.center).norm());
      faces_.push_back(f);
    }
  }

  struct Point {
    Vec3 at = Vec3::Zero();
    double distance = INFINITY;
    bool behind = false;  ///< Whether x is behind that triangle: inside, for a convex solid.
  };

  [[nodiscard]] Point find(const Vec3& x) const {
    Point best;
    for (const Face& f : faces_) {
      const double far = best.distance + f.radius;
      if ((x - f.center).squaredNorm() > far * far) continue;
      const Vec3 at = nearestOn(f, x);
      const double d = (x - at).norm();
      if (d < best.distance) best = {at, d, f.normal.dot(x - f.v[0]) < 0};
    }
    return best;
  }

 private:
  struct Face {
    Vec3 v[3];
    Vec3 normal = Vec3::Zero(), center = Vec3::Zero();
    double radius = 0;
  };

  /** The foot on the plane if it is over the triangle, else the best of the edges. */
  static Vec3 nearestOn(const Face& f, const Vec3& x) {
    bool over = true;
    Vec3 best = x - f.normal.dot(x - f.v[0]) * f.normal;
    for (int i = 0; i < 3; ++i) over = over && f.normal.dot((f.v[(i + 1) % 3] - f.v[i]).cross(x - f.v[i])) >= 0;
    if (over) return best;
    double least = INFINITY;
    for (int i = 0; i < 3; ++i) {
      const Vec3 at = nearestOnSegment(f.v[i], f.v[(i + 1) % 3], x);
      if ((at - x).norm() >= least) continue;
      least = (at - x).norm();
      best = at;
    }
    return best;
  }

  std::vector<Face> faces_;
};

}  // namespace hapticd::test
