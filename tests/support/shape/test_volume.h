/** @file
 * Small volumes for tests: of shapes whose distance is known in closed form, and of any closed mesh.
 */
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "daemon/builder/volume/mesh_volume.h"
#include "rt/volume/volume_view.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd::test {

/** Owns the image of a view. */
struct TestVolume {
  VolumeImage image;
  VolumeView view;

  /** Opened as the daemon does; the test fails if it cannot. */
  static TestVolume open(Result<VolumeImage> image) {
    TestVolume volume;
    EXPECT_TRUE(image.ok()) << toString(image.error());
    if (!image) return volume;
    volume.image = std::move(*image);
    const auto view = validateVolume(bytesOf(volume.image));
    EXPECT_TRUE(view.ok()) << toString(view.error());
    if (view) volume.view = *view;
    return volume;
  }
};

/** By a function of the point in O. */
class AnalyticField : public DistanceField {
 public:
  AnalyticField(const VolumeLattice& lattice, std::function<double(const Vec3&)> distance)
      : lattice_(lattice), distance_(std::move(distance)) {}
  float at(const Lattice3& point) override { return static_cast<float>(distance_(lattice_.at(point))); }

 private:
  VolumeLattice lattice_;
  std::function<double(const Vec3&)> distance_;
};

inline TestVolume volumeOfMesh(const TestMesh& mesh, double voxel, const VolumeOptions& options = {}) {
  BuildMonitor monitor;
  return TestVolume::open(buildMeshVolume(mesh.vertices, mesh.triangles, voxel, options, monitor));
}

/** The triangles give the points alone; the field is the function's. */
inline TestVolume volumeOf(const TestMesh& mesh, std::function<double(const Vec3&)> distance, double voxel,
                           const VolumeOptions& options = {}) {
  Vec3 lower = Vec3::Constant(INFINITY), upper = -lower;
  for (const auto& v : mesh.vertices) {
    lower = lower.cwiseMin(Vec3(v[0], v[1], v[2]));
    upper = upper.cwiseMax(Vec3(v[0], v[1], v[2]));
  }
  VolumeSource source;
  source.lattice = latticeAbout(lower, upper, voxel);
  AnalyticField field(source.lattice, std::move(distance));
  source.field = &field;
  source.vertices = mesh.vertices;
  source.triangles = mesh.triangles;
  source.options = options;
  BuildMonitor monitor;
  return TestVolume::open(writeVolume(source, monitor));
}

inline TestVolume sphereVolume(double radius, double voxel, std::uint32_t stacks = 24,
                               const VolumeOptions& options = {}) {
  return volumeOf(
      sphereMesh(radius, stacks), [=](const Vec3& x) { return x.norm() - radius; }, voxel, options);
}

inline TestVolume boxVolume(const Vec3& half, double voxel, const VolumeOptions& options = {}) {
  return volumeOf(
      boxMesh(half),
      [=](const Vec3& x) {
        return distanceTo(Shape{ShapeKind::kBox, half}, x);
      },
      voxel, options);
}

/** About z: `ring` from the axis to the tube's middle, `tube` its radius. */
inline TestMesh torusMesh(double ring, double tube, std::uint32_t around, std::uint32_t across) {
  TestMesh m;
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const double a = 2 * M_PI * i / around, b = 2 * M_PI * j / across, r = ring + tube * cos(b);
      m.addVertex({r * cos(a), r * sin(a), tube * sin(b)});
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % around * across + j % across; };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < across; ++j) m.addQuad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  m.flags = HD_MESH_CLOSED;
  return m;
}

inline TestVolume torusVolume(double ring, double tube, double voxel, const VolumeOptions& options = {}) {
  return volumeOf(
      torusMesh(ring, tube, 64, 32), [=](const Vec3& x) { return std::hypot(x.head<2>().norm() - ring, x.z()) - tube; },
      voxel, options);
}

}  // namespace hapticd::test
