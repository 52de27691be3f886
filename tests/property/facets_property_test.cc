/** @file
 * A flat side of many facets feels like one of two, although rounding its vertices leaves them not quite in one plane:
 * friction keeps the hand no deeper. A failure names its seed.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/finer_mesh.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

/** How far the surface of a convex solid about the origin is in that direction. */
double reach(const TestMesh& solid, const Vec3& direction) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : solid.triangles) {
    const auto corner = [&](int i) {
      return Eigen::Map<const Eigen::Vector3f>(solid.vertices[t[i]].data()).cast<double>();
    };
    const Vec3 a = corner(0), n = (Vec3(corner(1)) - a).cross(Vec3(corner(2)) - a);
    if (n.dot(direction) > 0) least = std::min(least, n.dot(a) / n.dot(direction));
  }
  return least;
}

/** Three sides that meet at 60 degrees, and two ends. */
TestMesh bar() {
  TestMesh m;
  for (const double y : {-0.03, 0.03}) {
    for (int i = 0; i < 3; ++i)
      m.addVertex({-0.0133 * std::sin(i * 2 * M_PI / 3), y, 0.0133 * std::cos(i * 2 * M_PI / 3)});
  }
  m.addTriangle(0, 1, 2);
  m.addTriangle(3, 5, 4);
  m.addQuad(0, 3, 4, 1);
  m.addQuad(1, 4, 5, 2);
  m.addQuad(2, 5, 3, 0);
  return m;
}

/** A ball strokes the solid all around, over its edges, up to 4 mm deep. */
void fineIsNoDeeper(const TestMesh& solid, std::uint32_t seed, double radius, double friction, int& touched) {
  constexpr double kSame = 1e-4;
  constexpr int kSoon = 20;  // Ticks: where the hand slips off it may be some later on the one than on the other.
  Random random(seed);
  const Pose X = random.pose(0.1);
  TestMesh meshes[2] = {test::finer(solid, 1, X), test::finer(solid, 12, X)};
  TestScene scenes[2];
  for (int k = 0; k < 2; ++k) {
    scenes[k].proxy.setRadius(radius);
    scenes[k].addMesh(meshes[k].view(), {}, {1000, 0, friction, friction});
  }
  Vec3 direction = random.vector(1).normalized(), turn = Vec3::Zero();
  double depth = -0.02, aim = 0;
  int deeper = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 100 == 0) turn = random.in(0.2, 3) * random.vector(1);
    if (i % 300 == 0) aim = random.in(-0.0005, 0.004);
    depth += 0.01 * (aim - depth);
    direction = (direction + 1e-3 * turn.cross(direction)).normalized();
    const Vec3 hip = X * ((reach(solid, direction) + radius - depth) * direction);
    for (TestScene& scene : scenes) scene.tick(hip);
    touched += scenes[1].contact.object != 0;
    deeper = scenes[1].contact.depth > scenes[0].contact.depth + kSame ? deeper + 1 : 0;
    ASSERT_LT(deeper, kSoon) << "tick " << i;
  }
}

TEST(FacetsProperty, FrictionKeepsTheHandNoDeeperOnManyThanOnFew) {
  int touched = 0;
  forSeeds(6, [&](unsigned seed) {
    for (const bool is_bar : {false, true}) {
      const TestMesh solid = is_bar ? bar() : test::boxMesh({0.02, 0.015, 0.01});
      for (const double radius : {0.001, 0.004}) {
        for (const double friction : {0.3, 0.8}) fineIsNoDeeper(solid, seed, radius, friction, touched);
      }
    }
  });
  EXPECT_GT(touched, 6 * 8 * 1500);
}

}  // namespace
}  // namespace hapticd
