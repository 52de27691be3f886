// Winding numbers against closed forms and a brute sum.
#include "daemon/builder/volume/winding.h"

#include <gtest/gtest.h>

#include "tests/support/seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd::test {
namespace {

TEST(Winding, ofATriangleIsItsSolidAngle) {
  const Vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), o = Vec3::Zero();
  EXPECT_NEAR(windingOfTriangle(x, y, z, o), 1.0 / 8, 1e-15);  // An octant.
  EXPECT_NEAR(windingOfTriangle(x, z, y, o), -1.0 / 8, 1e-15);
  EXPECT_EQ(windingOfTriangle(x, y, z, x), 0);                // On a corner,
  EXPECT_EQ(windingOfTriangle(x, y, z, (x + y) / 2), 0);      // an edge,
  EXPECT_EQ(windingOfTriangle(x, y, Vec3(-1, -1, 0), o), 0);  // and within it.
  // A rectangle of 2a by 2b seen from the height h over its middle: 4 asin(a b / sqrt((a^2 + h^2) (b^2 + h^2))).
  const double a = 0.3, b = 1.7;
  for (const double h : {1e-6, 0.01, 0.4, 30.0}) {
    const Vec3 p(-a, -b, 0), q(a, -b, 0), r(a, b, 0), s(-a, b, 0), eye(0, 0, -h);  // Behind it: inside.
    const double angle = 4 * std::asin(a * b / std::sqrt((a * a + h * h) * (b * b + h * h)));
    EXPECT_NEAR(windingOfTriangle(p, q, r, eye) + windingOfTriangle(p, r, s, eye), angle / (4 * M_PI), 1e-9) << h;
  }
}

/** A crumpled ball without every seventh triangle, far from the origin. */
TestMesh holey() {
  std::mt19937 random(seedOf(3));
  TestMesh whole = crumpled(random, 16), mesh;
  for (const auto& v : whole.vertices) mesh.addVertex(Vec3(v[0] + 5, v[1], v[2] - 3));
  for (std::size_t t = 0; t < whole.triangles.size(); ++t)
    if (t % 7 != 0) mesh.triangles.push_back(whole.triangles[t]);
  return mesh;
}

TEST(Winding, byTheTreeIsTheSumOverTheTriangles) {
  TestMesh mesh = holey();
  const MeshView& view = *mesh.view();
  const WindingTree tree(view);
  std::mt19937 random(seedOf(4));
  double worst = 0, squares = 0;
  constexpr int kPoints = 4000;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3 x = Vec3(5, 0, -3) + randomPoint(random, i % 4 == 0 ? 10 : 1.5);
    const double error = tree.at(x) - windingNumber(view, x);
    worst = std::max(worst, std::abs(error));
    squares += error * error;
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(std::sqrt(squares / kPoints), 0.002);
}

TEST(Winding, ofFarAwaySurfaceIsThatOfItsAreaVector) {
  TestMesh mesh = holey();
  const MeshView& view = *mesh.view();
  const WindingTree tree(view);
  for (int k = 0; k < 3; ++k) {
    const Vec3 x = Vec3(5, 0, -3) + 20 * Vec3::Unit(k);
    EXPECT_NEAR(tree.at(x), windingNumber(view, x), 2e-3 * std::abs(windingNumber(view, x)) + 1e-6);
  }
}

}  // namespace
}  // namespace hapticd::test
