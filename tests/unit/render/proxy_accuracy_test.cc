/** @file
 * How near the force comes to that of the exact nearest point of the mesh, on tessellated spheres.
 */
#include <gtest/gtest.h>

#include "tests/support/shape/brute_nearest.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kForce = 1;

/** On the unit sphere, pole to pole in 20 turns and 10 s. */
Vec3 spiral(double t) {
  const double polar = M_PI * t / 10, azimuth = 2 * M_PI * 2 * t;
  return {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
}

TEST(ProxyAccuracy, OnSpheresTheForceIsThatOfTheNearestPoint) {
  struct Setting {
    double radius, stiffness;
  };
  for (const auto& [radius, stiffness] : {Setting{0.001, 2000}, Setting{0.05, 100}, Setting{0.05, 1000}}) {
    for (const std::uint32_t stacks : {4u, 8u, 16u, 32u, 64u}) {
      TestMesh mesh = test::sphereMesh(radius, stacks);
      const test::BruteNearest surface(*mesh.view());
      TestScene t;
      t.addMesh(mesh.view(), {}, {stiffness, 0, 0, 0});
      t.tick(2 * radius * spiral(0));
      const int stride = 1 + static_cast<int>(mesh.triangles.size()) / 1000;  // Of the samples that are judged.
      double ours = 0, nearest = 0;
      for (int i = 0; i < 10000; ++i) {
        const Vec3 n = spiral((i + 0.5) * 1e-3), hip = (radius - kForce / stiffness) * n;
        const Vec3 force = t.tick(hip).force;
        if (i % stride != 0) continue;
        const auto q = surface.find(hip);
        ours += (force - kForce * n).squaredNorm();
        nearest += ((q.behind ? Vec3(stiffness * (q.at - hip)) : Vec3(Vec3::Zero())) - kForce * n).squaredNorm();
      }
      EXPECT_LE(ours, 1.02 * nearest) << radius << " " << stiffness << " " << stacks;
      EXPECT_GT(nearest, 0);
    }
  }
}

TEST(ProxyAccuracy, TheForceDoesNotDependOnTheWayThere) {
  // A coarse ball pressed at one place, come to from many sides: a proxy that waits at convex edges remembers each.
  TestMesh mesh = test::sphereMesh(0.02, 4);
  const test::BruteNearest surface(*mesh.view());
  for (int k = 0; k < 200; ++k) {
    const Vec3 n = spiral(0.05 * k + 0.013), end = 0.014 * n;
    for (int from = 0; from < 6; ++from) {
      const Vec3 side = (from < 3 ? 1 : -1) * Vec3::Unit(from % 3), start = 0.022 * (n + 0.7 * side).normalized();
      TestScene t;
      t.addMesh(mesh.view());
      t.tick(start);
      SurfaceContact c;
      for (int i = 1; i <= 40; ++i) c = t.tick(start + i / 40.0 * (end - start));
      ASSERT_NEAR(c.force.norm(), 1000 * surface.find(end).distance, 1e-4) << k << " " << from;
    }
  }
}

}  // namespace
}  // namespace hapticd
