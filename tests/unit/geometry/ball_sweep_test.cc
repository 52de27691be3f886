/** @file
 * Swept balls against what defines them: the distance of their centre, traced step by step, all triangles one by one.
 */
#include <gtest/gtest.h>

#include "rt/geometry/sweep/sweep.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::randomPoint;
using test::TestMesh;

constexpr double kScales[] = {1e-3, 1, 40};

/** First t at which the centre is within `radius` of the shape, by sphere tracing; 2 if never. */
template <class Distance>
double traced(const Sweep& s, Distance&& distance, double scale) {
  double t = 0;
  const double length = s.d.norm();
  for (int i = 0; i < 20000 && t <= 1; ++i) {
    const double gap = distance(s.a + t * s.d) - s.radius;
    if (gap < 1e-10 * scale) return t;
    t += gap / length;
  }
  return 2;
}

template <class Distance>
double deepest(const Sweep& s, Distance&& distance) {
  double least = 1e300;
  for (int k = 0; k <= 400; ++k) least = std::min(least, distance(s.a + k / 400.0 * s.d) - s.radius);
  return least;
}

/** Compares one sweep with the tracer; 1 if both met the shape. */
template <class Distance>
int compare(const Sweep& s, SweepResult result, const SweepHit& hit, Distance&& distance, double scale) {
  const double t = traced(s, distance, scale);
  if (result == SweepResult::kNone) {
    if (t < 2) {
      EXPECT_GT(deepest(s, distance), -1e-4 * scale) << "passed through";
    }
    return 0;
  }
  EXPECT_LE(t, 1) << "met what is not there";
  const Vec3 x = s.a + hit.t * s.d;
  EXPECT_NEAR(distance(x) - s.radius, 0, 1e-13 * scale);
  EXPECT_NEAR((hit.t - t) * s.d.dot(hit.normal), 0, 1e-6 * scale);
  EXPECT_NEAR(hit.normal.norm(), 1, 1e-13);
  EXPECT_LT(hit.normal.dot(s.d), 0);
  EXPECT_NEAR(hit.normal.dot(x) - hit.offset, 0, 1e-13 * scale);
  EXPECT_GE(hit.height, -1e-13 * scale);
  return 1;
}

TEST(BallSweep, PrimitivesAreMetWhereTheirDistanceIsTheRadius) {
  std::mt19937 random(seedOf(1));
  for (const double scale : kScales) {
    for (const Shape& unit : test::kPrimitives) {
      Shape shape = unit;
      shape.size *= scale;
      const auto distance = [&](const Vec3& x) { return test::distanceTo(shape, x); };
      int hits = 0;
      for (int i = 0; i < 1500; ++i) {
        Sweep s;
        s.a = scale * randomPoint(random, 1.8);
        s.d = scale * randomPoint(random, 1.5) - s.a;
        s.radius = scale * (i % 3 == 0 ? 1e-3 : 0.25);
        s.limit = 10;
        const double start = distance(s.a) - s.radius;
        SweepHit hit;
        const SweepResult result = sweepShape(shape, s, hit);
        if (start < 0) {
          ASSERT_EQ(result, SweepResult::kNone) << "overlaps at the start";
          continue;
        }
        hits += compare(s, result, hit, distance, scale);
        if (result == SweepResult::kHit) {
          ASSERT_NEAR(distance(hit.point), 0, 1e-12 * scale);
        }
        ASSERT_FALSE(::testing::Test::HasFailure()) << static_cast<int>(shape.kind) << " " << i << " " << scale;
      }
      EXPECT_GT(hits, 300);
    }
  }
}

TEST(BallSweep, EdgesAndVerticesOfABoxAreNamed) {
  const Shape box{ShapeKind::kBox, Vec3(1, 1, 1)};
  const auto meet = [&](const Vec3& from, const Vec3& to) {
    Sweep s;
    s.a = from;
    s.d = to - from;
    s.radius = 0.5;
    s.limit = 1;
    SweepHit hit;
    EXPECT_EQ(sweepShape(box, s, hit), SweepResult::kHit);
    return hit;
  };
  const SweepHit face = meet({0.2, 0.3, 3}, {0.2, 0.3, 0});
  EXPECT_EQ(face.kind, FeatureKind::kFace);
  EXPECT_EQ(face.feature, 4u);
  EXPECT_DOUBLE_EQ(face.t, 0.5);
  EXPECT_EQ(face.normal, Vec3::UnitZ());
  EXPECT_DOUBLE_EQ(face.offset, 1.5);
  const SweepHit edge = meet({1.3, 0, 3}, {1.3, 0, 0});
  EXPECT_EQ(edge.kind, FeatureKind::kEdge);
  EXPECT_NEAR(edge.t, (3 - 1.4) / 3, 1e-15);
  EXPECT_LT((edge.normal - Vec3(0.6, 0, 0.8)).norm(), 1e-15);
  EXPECT_LT((edge.point - Vec3(1, 0, 1)).norm(), 1e-15);
  EXPECT_EQ(meet({3, 3, 3}, {0, 0, 0}).kind, FeatureKind::kVertex);
  EXPECT_NE(edge.feature, meet({-1.3, 0, 3}, {-1.3, 0, 0}).feature);
}

TEST(BallSweep, ASoupIsMetWhereItsDistanceIsTheRadius) {
  std::mt19937 random(seedOf(3));
  for (const double scale : kScales) {
    TestMesh soup;
    for (int i = 0; i < 150; ++i) {
      const Vec3 c = scale * randomPoint(random, 1);
      const auto corner = [&] { return soup.addVertex(c + scale * randomPoint(random, 0.2)); };
      const auto a = corner(), b = corner();
      soup.addTriangle(a, b, corner());
    }
    const MeshView& mesh = *soup.view();
    const auto distance = [&](const Vec3& x) { return test::distanceTo(mesh, x); };
    int hits = 0;
    for (int i = 0; i < 400; ++i) {
      Sweep s;
      s.a = scale * randomPoint(random, 1.3);
      s.d = scale * randomPoint(random, i % 3 == 0 ? 0.1 : 2.0);
      s.radius = scale * (i % 4 == 0 ? 1e-3 : 0.05);
      s.two_sided = true;
      s.limit = 1u << 30;
      if (distance(s.a) < s.radius) continue;
      SweepHit hit;
      const SweepResult result = sweepMesh(mesh, s, hit);
      hits += compare(s, result, hit, distance, scale);
      ASSERT_FALSE(::testing::Test::HasFailure()) << i << " " << scale;
    }
    EXPECT_GT(hits, 40);
  }
}

TEST(BallSweep, AClosedMeshIsMetFromOutsideWhereItsDistanceIsTheRadius) {
  std::mt19937 random(seedOf(4));
  const Vec3 center(0.123, -0.456, 0.789);
  for (const double radius : {1e-4, 0.02, 0.3}) {
    TestMesh ball = test::sphereMesh(0.37, 8, center);
    const MeshView& mesh = *ball.view();
    const auto distance = [&](const Vec3& x) { return test::distanceTo(mesh, x); };
    for (int i = 0; i < 400; ++i) {
      Sweep s;
      s.a = center + randomPoint(random, 1).normalized() * 0.8;
      s.d = center + randomPoint(random, 0.2) - s.a;  // To a point well inside.
      s.radius = radius;
      s.limit = 1u << 30;
      SweepHit hit;
      const SweepResult result = sweepMesh(mesh, s, hit);
      ASSERT_EQ(result, SweepResult::kHit) << i;
      compare(s, result, hit, distance, 1);
      ASSERT_FALSE(::testing::Test::HasFailure()) << i;
    }
  }
}

TEST(BallSweep, TheEdgeOfAKnifeStopsTheBallAndItsInsideDoesNot) {
  // A closed plate, thin as paper: a ball on its rim sees both faces nearly from the side.
  TestMesh plate = test::boxMesh(Vec3(1, 1, 1e-5));
  const MeshView& mesh = *plate.view();
  std::mt19937 random(seedOf(5));
  for (int i = 0; i < 300; ++i) {
    Sweep s;
    s.a = Vec3(2, 0.9 * randomPoint(random, 1).y(), 0.01 * randomPoint(random, 1).z());
    s.d = Vec3(-2, 0, 0);
    s.radius = 0.1;
    s.limit = 1u << 20;
    SweepHit hit;
    ASSERT_EQ(sweepMesh(mesh, s, hit), SweepResult::kHit);
    ASSERT_NEAR(test::distanceTo(mesh, s.a + hit.t * s.d), 0.1, 1e-13);
  }
  TestMesh hollow = test::sphereMesh(1, 6);
  for (int i = 0; i < 2000; ++i) {
    Sweep s;
    s.a = randomPoint(random, 0.3);
    s.d = randomPoint(random, 0.5) - s.a;
    s.radius = 0.2;
    s.limit = 1u << 20;
    SweepHit hit;
    ASSERT_EQ(sweepMesh(*hollow.view(), s, hit), SweepResult::kNone) << "held from inside, " << i;
  }
}

TEST(BallSweep, NothingIsMetFromInside) {
  std::mt19937 random(seedOf(6));
  int hits = 0;
  for (int shape = 0; shape < 10; ++shape) {
    TestMesh mesh = test::crumpled(random, 5);
    for (int i = 0; i < 1500; ++i) {
      Sweep s;
      s.a = randomPoint(random, 1.2);
      s.d = randomPoint(random, 1);
      s.radius = 0.03;
      s.limit = 1u << 20;
      SweepHit hit;
      if (sweepMesh(*mesh.view(), s, hit) != SweepResult::kHit) continue;
      // A ball that overlaps other triangles from the start may be stopped anywhere.
      if (test::distanceTo(*mesh.view(), s.a + hit.t * s.d) < s.radius - 1e-9) continue;
      ++hits;
      ASSERT_LT(test::windingNumber(*mesh.view(), s.a + hit.t * s.d), 0.5) << shape << " " << i;
    }
  }
  EXPECT_GT(hits, 1000);
  // A narrow groove, its bottom touched from below: the centre is in front of the far wall's plane, and yet inside.
  TestMesh groove = test::heightMesh(1, 40, [](double x, double) { return std::min(20 * std::abs(x), 1.0); });
  Sweep s;
  s.a = Vec3(0.027, 0.012, -0.3);
  s.d = Vec3(0, 0, 0.295);
  s.radius = 0.03;
  s.limit = 1u << 20;
  SweepHit hit;
  EXPECT_EQ(sweepMesh(*groove.view(), s, hit), SweepResult::kNone);
}

TEST(BallSweep, AnOneSidedSheetStopsFromItsFrontOnly) {
  TestMesh sheet = test::heightMesh(1, 4, [](double, double) { return 0.0; });
  for (const double sign : {1.0, -1.0}) {
    Sweep s;
    s.a = Vec3(0.1, 0.2, sign);
    s.d = Vec3(0, 0, -sign);
    s.radius = 0.25;
    s.limit = 1u << 20;
    SweepHit hit;
    EXPECT_EQ(sweepMesh(*sheet.view(), s, hit), sign > 0 ? SweepResult::kHit : SweepResult::kNone);
    s.two_sided = true;
    hit = {};
    ASSERT_EQ(sweepMesh(*sheet.view(), s, hit), SweepResult::kHit);
    EXPECT_DOUBLE_EQ(hit.t, 0.75);
    EXPECT_EQ(hit.normal, Vec3(0, 0, sign));
  }
}

TEST(BallSweep, WhichOfTwoTrianglesIsTriedFirstChangesNothing) {
  // A ball a hair above the edge of both, which then meet it at the same time to the bit, or nearly.
  std::mt19937 random(seedOf(7));
  int hits = 0;
  for (int pair = 0; pair < 2000; ++pair) {
    TestMesh mesh;
    for (int i = 0; i < 4; ++i) mesh.addVertex(randomPoint(random, 1));
    mesh.addTriangle(0, 1, 2);
    mesh.addTriangle(1, 0, 3);
    const MeshView& view = *mesh.view();
    const Vec3 from = view.vertex(0, 0), along = view.vertex(0, 1) - from;
    for (int i = 0; i < 40; ++i) {
      Vec3 out = randomPoint(random, 1);
      out -= out.dot(along) / along.squaredNorm() * along;
      Sweep sweep;
      sweep.radius = 0.3;
      sweep.a = from + 0.025 * i * along + sweep.radius * (1 + 1e-12) * out.normalized();
      sweep.d = randomPoint(random, 0.1);
      sweep.two_sided = pair % 2 == 1;
      sweep.limit = 100;
      SweepHit hit[2];
      for (std::uint32_t first = 0; first < 2; ++first) {
        Sweep s = sweep;
        s.hint = first;
        hits += sweepMesh(view, s, hit[first]) == SweepResult::kHit ? 1 : 0;
      }
      ASSERT_EQ(hit[0].t, hit[1].t) << pair << " " << i;
      ASSERT_EQ(hit[0].feature, hit[1].feature) << pair << " " << i;
      ASSERT_EQ(hit[0].normal, hit[1].normal) << pair << " " << i;
    }
  }
  EXPECT_GT(hits, 20000);
}

TEST(BallSweep, ExhaustionIsReported) {
  TestMesh mesh = test::sphereMesh(1, 30);
  Sweep sweep;
  sweep.a = Vec3(0, 0, 2);
  sweep.d = Vec3(0.1, 0, -2);
  sweep.radius = 0.1;
  sweep.limit = 5;
  SweepHit hit;
  EXPECT_EQ(sweepMesh(*mesh.view(), sweep, hit), SweepResult::kExhausted);
}

}  // namespace
}  // namespace hapticd
