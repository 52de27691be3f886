/** @file
 * Swept queries against what defines them: signed distances for primitives, all triangles for the tree.
 */
#include "rt/geometry/sweep/sweep.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::distanceTo;
using test::kPrimitives;
using test::randomPoint;
using test::TestMesh;

/** First zero of the signed distance by sphere tracing, or 2. */
double traced(const Shape& s, const Vec3& a, const Vec3& d) {
  double t = 0;
  for (int i = 0; i < 100000 && t <= 1; ++i) {
    const double h = distanceTo(s, a + t * d);
    if (h < 1e-11) return t;
    t += h / d.norm();
  }
  return 2;
}

TEST(Sweep, PrimitivesAreEnteredWhereTheirDistanceIsZero) {
  std::mt19937 random(seedOf(1));
  for (const Shape& shape : kPrimitives) {
    int hits = 0, compared = 0;
    for (int i = 0; i < 4000; ++i) {
      Sweep sweep;
      sweep.a = randomPoint(random, 1.5);
      sweep.d = randomPoint(random, 1.5) - sweep.a;
      sweep.limit = 1000;
      const double start = distanceTo(shape, sweep.a);
      SweepHit hit;
      const SweepResult result = sweepShape(shape, sweep, hit);
      if (start < 0) {
        ASSERT_EQ(result, SweepResult::kNone) << "inside at the start";
        continue;
      }
      const double t = traced(shape, sweep.a, sweep.d);
      // Grazing lines may fall on either side within the tracer's own tolerance.
      if (t < 2 && result == SweepResult::kNone) {
        double deepest = 1;
        for (int k = 0; k <= 1000; ++k) deepest = std::min(deepest, distanceTo(shape, sweep.a + k * 1e-3 * sweep.d));
        ASSERT_GT(deepest, -1e-5) << static_cast<int>(shape.kind) << " " << i;
        continue;
      }
      ASSERT_EQ(result == SweepResult::kHit, t < 2) << static_cast<int>(shape.kind) << " " << i;
      ++compared;
      if (t >= 2) continue;
      ++hits;
      const Vec3 x = sweep.a + hit.t * sweep.d;
      ASSERT_NEAR(distanceTo(shape, x), 0, 1e-13);
      ASSERT_NEAR(hit.t, t, 1e-4);
      ASSERT_NEAR(hit.normal.norm(), 1, 1e-14);
      ASSERT_NEAR(hit.normal.dot(x) - hit.offset, 0, 1e-13);
      ASSERT_LT(hit.normal.dot(sweep.d), 0);
      ASSERT_NEAR(distanceTo(shape, x + 1e-3 * hit.normal), 1e-3, 1e-12) << "outward";
    }
    EXPECT_GT(hits, 400);
    EXPECT_GT(compared, 1500);
  }
}

TEST(Sweep, AStartOnTheSurfaceEntersAndOneOnTheWayOutDoesNot) {
  std::mt19937 random(seedOf(2));
  for (const Shape& shape : kPrimitives) {
    for (int i = 0; i < 300; ++i) {
      Sweep in;
      in.a = randomPoint(random, 1.5);
      in.d = (shape.kind == ShapeKind::kPlane ? Vec3(in.a.x(), in.a.y(), -5) : randomPoint(random, 0.05)) - in.a;
      in.limit = 1000;
      in.tolerance = 1e-13;
      SweepHit hit;
      if (distanceTo(shape, in.a) < 0 || sweepShape(shape, in, hit) != SweepResult::kHit) continue;
      const Vec3 x = in.a + hit.t * in.d;
      for (const double below : {0.0, 2e-14}) {
        Sweep again = in, out = in;
        again.a = out.a = x - below * hit.normal;
        out.d = hit.normal - 0.3 * (in.d - in.d.dot(hit.normal) * hit.normal) / in.d.norm();
        SweepHit second;
        ASSERT_EQ(sweepShape(shape, again, second), SweepResult::kHit) << static_cast<int>(shape.kind);
        ASSERT_LT(second.t, 1e-11);
        SweepHit third;
        ASSERT_EQ(sweepShape(shape, out, third), SweepResult::kNone) << static_cast<int>(shape.kind);
      }
    }
  }
}

TEST(Sweep, TheTreeFindsWhatAllTrianglesFind) {
  std::mt19937 random(seedOf(3));
  for (const std::uint32_t count : {1u, 2u, 5u, 100u, 3000u}) {
    TestMesh soup;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3 c = randomPoint(random, 1);
      const auto a = soup.addVertex(c + randomPoint(random, 0.2)), b = soup.addVertex(c + randomPoint(random, 0.2));
      soup.addTriangle(a, b, soup.addVertex(c + randomPoint(random, 0.2)));
    }
    const MeshView& tree = *soup.view();
    const std::vector<hd_bvh_node> all = test::flatTree(tree.triangle_count);
    MeshView flat = tree;
    flat.nodes = all.data();
    flat.node_count = static_cast<std::uint32_t>(all.size());
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      Sweep a;
      a.a = randomPoint(random, 1.3);
      a.d = randomPoint(random, i % 3 == 0 ? 0.05 : 2.0);
      if (i % 5 == 0) a.d[i % 3] = 0;
      a.two_sided = i % 2 == 0;
      a.limit = 1u << 30;
      Sweep b = a;
      SweepHit x, y;
      ASSERT_EQ(sweepMesh(tree, a, x), sweepMesh(flat, b, y));
      ASSERT_EQ(x.t, y.t);
      ASSERT_EQ(x.normal, y.normal);
      hits += x.t < 1;
      ASSERT_LT(a.work, count == 3000 ? b.work : 1000);
    }
    EXPECT_GT(hits, count >= 100 ? 50 : -1);
  }
}

TEST(Sweep, NoSegmentSlipsBetweenTrianglesOfAClosedMesh) {
  // Aimed at vertices, edges and along edges of a sphere, off the grid of its coordinates.
  std::mt19937 random(seedOf(4));
  std::uniform_real_distribution<double> u(0, 1);
  for (const std::uint32_t stacks : {3u, 8u, 24u}) {
    TestMesh mesh = test::sphereMesh(0.37, stacks, Vec3(0.123, -0.456, 0.789));
    const MeshView& view = *mesh.view();
    const Vec3 center(0.123, -0.456, 0.789);
    for (int i = 0; i < 20000; ++i) {
      const std::uint32_t t = static_cast<std::uint32_t>(u(random) * view.triangle_count);
      const int k = static_cast<int>(3 * u(random));
      const double s = i % 4 == 0 ? 0 : (i % 4 == 1 ? 0.5 : u(random));
      const Vec3 aim = (1 - s) * view.vertex(t, k) + s * view.vertex(t, (k + 1) % 3);
      // An end well inside, on the line from a start well outside through the aim.
      const Vec3 inner = center + 0.2 * randomPoint(random, 0.37) / std::sqrt(3.0);
      Sweep sweep;
      sweep.a = aim + (aim - inner) * (0.01 + 5 * u(random));
      sweep.d = inner - sweep.a;
      sweep.limit = 1u << 30;
      if ((sweep.a - center).norm() < 0.371) continue;
      SweepHit hit;
      ASSERT_EQ(sweepMesh(view, sweep, hit), SweepResult::kHit) << stacks << " " << i;
      ASSERT_LT((sweep.a + hit.t * sweep.d - aim).norm(), 0.2);
    }
  }
}

TEST(Sweep, AnEmptyMeshAndAMissingOneMeetNothing) {
  TestMesh empty;
  Sweep sweep;
  sweep.d = Vec3(1, 0, 0);
  sweep.limit = 10;
  SweepHit hit;
  EXPECT_EQ(sweepMesh(*empty.view(), sweep, hit), SweepResult::kNone);
  EXPECT_EQ(sweepShape({ShapeKind::kMesh, Vec3::Zero(), nullptr}, sweep, hit), SweepResult::kNone);
  EXPECT_EQ(sweepShape({}, sweep, hit), SweepResult::kNone);
}

TEST(Sweep, ExhaustionIsReported) {
  TestMesh mesh = test::sphereMesh(1, 30);
  Sweep sweep;
  sweep.a = Vec3(0, 0, 2);
  sweep.d = Vec3(0.1, 0, -2);
  sweep.limit = 5;
  SweepHit hit;
  EXPECT_EQ(sweepMesh(*mesh.view(), sweep, hit), SweepResult::kExhausted);
}

/** Nearer to the sheet than the tolerance, what goes away from it goes, and what goes into it is met. */
TEST(Sweep, ATwoSidedSheetDoesNotHoldWhatLeavesIt) {
  TestMesh mesh = test::heightMesh(1, 4, [](double, double) { return 0.0; });
  const MeshView& view = *mesh.view();
  Sweep sweep;
  sweep.two_sided = true;
  sweep.tolerance = 1e-14;
  sweep.limit = 1u << 20;
  for (const double side : {1.0, -1.0}) {
    for (const double height : {0.2e-14, 0.5e-14, 2e-14}) {
      sweep.a = Vec3(0.1, 0.2, side * height);
      SweepHit hit;
      sweep.d = Vec3(0.1, 0, side);
      EXPECT_EQ(sweepMesh(view, sweep, hit), SweepResult::kNone) << height;
      sweep.d = Vec3(0.1, 0, -side);
      EXPECT_EQ(sweepMesh(view, sweep, hit), SweepResult::kHit) << height;
    }
  }
}

}  // namespace
}  // namespace hapticd
