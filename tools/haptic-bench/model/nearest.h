/** @file
 * The exact nearest point of a mesh, by trying every triangle: the yardstick of the benchmark.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** A point of the surface. */
struct SurfacePoint {
  Vec3 point = Vec3::Zero();
  /** Unit; of the face, or summed over the faces that meet at the edge or (weighted by their angle) vertex. */
  Vec3 normal = Vec3::Zero();
  double distance = 0;  ///< Not negative.
  bool inside = false;  ///< Below the surface there: its sign is right for closed meshes (Baerentzen and Aanaes 2005).
  std::uint32_t triangle = 0;

  /** Unit, away from the surface through `x`, whose nearest point this is; the normal where `x` lies on the surface. */
  [[nodiscard]] Vec3 outward(const Vec3& x) const {
    constexpr double kOnIt = 1e-12;  // [m]: what lies between is rounding, which points anywhere.
    if (distance <= kOnIt) return normal;
    return Vec3(inside ? point - x : x - point) / distance;
  }
};

/** A mesh ready to be asked. */
class NearestPoint {
 public:
  /** Keeps what it needs of the model. Triangles without area are never nearest. */
  explicit NearestPoint(const Model& model);

  [[nodiscard]] SurfacePoint find(const Vec3& x) const;
  /** Normal of a vertex: the faces' about it, weighted by their angles; zero where they cancel. */
  [[nodiscard]] const Vec3& vertexNormal(std::uint32_t vertex) const { return vertex_normals_[vertex]; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  /** What a first look at a triangle needs: a ball about it. */
  struct Ball {
    float x, y, z, radius;
  };
  struct Face {
    Vec3 a, ab, ac;
    Vec3 normal;
    std::array<std::uint32_t, 3> vertices;
    std::array<Vec3, 3> edge_normals;  ///< Of the edges ab, bc, ca.
  };

  std::vector<Ball> balls_;
  std::vector<Face> faces_;
  std::vector<Vec3> vertex_normals_;
};

/** The box about it. */
[[nodiscard]] Eigen::AlignedBox3d boxOf(const Model& model);

/**
 * Throws Failure, "WHAT lie ... off the surface", for points of that distance rms [m] from it: a tenth of the model.
 * What has anything to do with it lies far nearer; what has another unit or frame seldom does.
 */
void requireNear(const Model& model, double rms, const std::string& what, const std::string& remedy);

}  // namespace haptic_bench
