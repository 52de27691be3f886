/** @file
 * A flat side of many facets feels like one of two, although rounding its vertices leaves them not quite in one plane:
 * friction keeps the hand no deeper. A failure names its seed.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/test_mesh.h"
#include "tests/support/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

/** Convex, about the origin. */
struct Solid {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;

  [[nodiscard]] Vec3 corner(std::size_t t, int i) const { return vertices[triangles[t][i]]; }
  /** How far the surface is in that direction. */
  [[nodiscard]] double reach(const Vec3& direction) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Vec3 n = (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
      if (n.dot(direction) > 0) least = std::min(least, n.dot(corner(t, 0)) / n.dot(direction));
    }
    return least;
  }
  /** Each triangle in cells^2. */
  void mesh(int cells, const Pose& X, TestMesh& out) const {
    std::map<std::tuple<long, long, long>, std::uint32_t> known;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto at = [&](int i, int j) {
        const Vec3 x = corner(t, 0) + (i * (corner(t, 1) - corner(t, 0)) + j * (corner(t, 2) - corner(t, 0))) / cells;
        const auto key = std::tuple(std::lround(x.x() * 1e8), std::lround(x.y() * 1e8), std::lround(x.z() * 1e8));
        const auto [place, is_new] = known.try_emplace(key, 0);
        if (is_new) place->second = out.addVertex(X * x);
        return place->second;
      };
      for (int i = 0; i < cells; ++i) {
        for (int j = 0; j < cells - i; ++j) {
          out.addTriangle(at(i, j), at(i + 1, j), at(i, j + 1));
          if (i + j < cells - 1) out.addTriangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
      }
    }
  }
};

Solid box() {
  Solid s;
  for (int i = 0; i < 8; ++i)
    s.vertices.emplace_back(i & 1 ? 0.02 : -0.02, i & 2 ? 0.015 : -0.015, i & 4 ? 0.01 : -0.01);
  s.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return s;
}

/** Three sides that meet at 60 degrees, and two ends. */
Solid bar() {
  Solid s;
  for (const double y : {-0.03, 0.03}) {
    for (int i = 0; i < 3; ++i)
      s.vertices.emplace_back(-0.0133 * std::sin(i * 2 * M_PI / 3), y, 0.0133 * std::cos(i * 2 * M_PI / 3));
  }
  s.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
  return s;
}

/** A ball strokes the solid all around, over its edges, up to 4 mm deep. */
void fineIsNoDeeper(const Solid& solid, std::uint32_t seed, double radius, double friction, int& touched) {
  constexpr double kSame = 1e-4;
  constexpr int kSoon = 20;  // Ticks: where the hand slips off it may be some later on the one than on the other.
  Random random(seed);
  const Pose X = random.pose(0.1);
  TestMesh meshes[2];
  TestScene scenes[2];
  for (int k = 0; k < 2; ++k) {
    solid.mesh(k == 0 ? 1 : 12, X, meshes[k]);
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
    const Vec3 hip = X * ((solid.reach(direction) + radius - depth) * direction);
    for (TestScene& scene : scenes) scene.tick(hip);
    touched += scenes[1].contact.object != 0;
    deeper = scenes[1].contact.depth > scenes[0].contact.depth + kSame ? deeper + 1 : 0;
    ASSERT_LT(deeper, kSoon) << "tick " << i;
  }
}

TEST(FacetsProperty, FrictionKeepsTheHandNoDeeperOnManyThanOnFew) {
  int touched = 0;
  forSeeds(6, [&](unsigned seed) {
    for (const Solid& solid : {box(), bar()}) {
      for (const double radius : {0.001, 0.004}) {
        for (const double friction : {0.3, 0.8}) fineIsNoDeeper(solid, seed, radius, friction, touched);
      }
    }
  });
  EXPECT_GT(touched, 6 * 8 * 1500);
}

}  // namespace
}  // namespace hapticd
