/** @file
 * Nearest points and gathered triangles against all triangles one by one, sides against winding numbers.
 */
#include "rt/geometry/nearest/nearest.h"

#include <gtest/gtest.h>

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::crumpled;
using test::randomPoint;
using test::TestMesh;

NearestQuery at(const Vec3& x) {
  NearestQuery query;
  query.x = x;
  query.limit = 1u << 30;
  return query;
}

TEST(Nearest, PrimitivesHaveTheirDistanceAndSide) {
  std::mt19937 random(seedOf(1));
  for (const Shape& shape : test::kPrimitives) {
    for (int i = 0; i < 3000; ++i) {
      NearestQuery query = at(randomPoint(random, 1.2));
      Nearest nearest;
      ASSERT_EQ(nearestOnShape(shape, query, nearest), NearestResult::kFound);
      const double distance = test::distanceTo(shape, query.x);
      ASSERT_NEAR(std::sqrt(nearest.squared_distance), std::abs(distance), 1e-14) << static_cast<int>(shape.kind);
      ASSERT_NEAR((query.x - nearest.point).norm(), std::abs(distance), 1e-14);
      ASSERT_NEAR(test::distanceTo(shape, nearest.point), 0, 1e-14);
      ASSERT_NEAR(test::distanceTo(shape, nearest.point + 1e-6 * nearest.normal), 1e-6, 1e-12);
      ASSERT_EQ(nearest.isInside(query.x), distance < 0);
    }
  }
  Nearest nearest;
  NearestQuery center = at(Vec3::Zero());
  EXPECT_EQ(nearestOnShape(test::kPrimitives[1], center, nearest), NearestResult::kFound);
  EXPECT_DOUBLE_EQ(nearest.squared_distance, 0.49);
}

TEST(Nearest, TheTreeFindsWhatAllTrianglesFind) {
  std::mt19937 random(seedOf(2));
  for (const double scale : {1e-3, 1.0, 40.0}) {
    TestMesh mesh = crumpled(random, 9);
    mesh.scale([&] { return scale; });
    const MeshView& view = *mesh.view();
    for (int i = 0; i < 500; ++i) {
      NearestQuery query = at(scale * randomPoint(random, 1.5));
      Nearest nearest;
      ASSERT_EQ(nearestOnMesh(view, query, nearest), NearestResult::kFound);
      const double distance = test::distanceTo(view, query.x);
      ASSERT_NEAR(std::sqrt(nearest.squared_distance), distance, 1e-14 * scale);
      ASSERT_NEAR((nearest.point - query.x).norm(), distance, 1e-14 * scale);
      const auto t = nearest.feature;
      ASSERT_NEAR(test::distanceToTriangle(view.vertex(t, 0), view.vertex(t, 1), view.vertex(t, 2), nearest.point), 0,
                  1e-14 * scale);
      query.reach = distance * 0.999;
      EXPECT_EQ(nearestOnMesh(view, query, nearest), NearestResult::kNone);
      query.reach = distance * 1.001;
      EXPECT_EQ(nearestOnMesh(view, query, nearest), NearestResult::kFound);
    }
  }
}

TEST(Nearest, ThePseudoNormalTellsInsideFromOutside) {
  std::mt19937 random(seedOf(3));
  int inside = 0, on_vertex = 0, on_edge = 0, face_is_wrong = 0;
  for (int shape = 0; shape < 8; ++shape) {
    TestMesh mesh = crumpled(random, 5);
    const MeshView& view = *mesh.view();
    for (int i = 0; i < 1500; ++i) {
      NearestQuery query = at(randomPoint(random, 1.5));
      Nearest nearest;
      ASSERT_EQ(nearestOnMesh(view, query, nearest), NearestResult::kFound);
      if (nearest.squared_distance < 1e-12) continue;
      const bool truth = test::windingNumber(view, query.x) > 0.5;
      ASSERT_EQ(nearest.isInside(query.x), truth) << shape << " " << i;
      inside += truth ? 1 : 0;
      on_vertex += nearest.kind == FeatureKind::kVertex ? 1 : 0;
      on_edge += nearest.kind == FeatureKind::kEdge ? 1 : 0;
      face_is_wrong += ((query.x - nearest.point).dot(nearest.normal) < 0) != truth ? 1 : 0;
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(on_vertex, 1000);
  EXPECT_GT(on_edge, 1000);
  EXPECT_GT(face_is_wrong, 100) << "the test must need the pseudo-normal";
}

TEST(Nearest, OnlyWhatIsTurnedTheRightWayCounts) {
  std::mt19937 random(seedOf(4));
  TestMesh mesh = crumpled(random, 8);
  const MeshView& view = *mesh.view();
  for (int i = 0; i < 500; ++i) {
    NearestQuery query = at(randomPoint(random, 1.5));
    query.turned = true;
    query.axis = randomPoint(random, 1).normalized();
    query.cosine = std::uniform_real_distribution<double>(-1, 0.98)(random);
    double least = HUGE_VAL;
    for (std::uint32_t t = 0; t < view.triangle_count; ++t) {
      if (faceNormal(view, t).dot(query.axis) <= query.cosine) continue;
      least =
          std::min(least, test::distanceToTriangle(view.vertex(t, 0), view.vertex(t, 1), view.vertex(t, 2), query.x));
    }
    Nearest nearest;
    const NearestResult result = nearestOnMesh(view, query, nearest);
    ASSERT_EQ(result == NearestResult::kFound, least < HUGE_VAL);
    if (result != NearestResult::kFound) continue;
    ASSERT_NEAR(std::sqrt(nearest.squared_distance), least, 1e-14);
    ASSERT_GT(nearest.normal.dot(query.axis), query.cosine - 1e-12);
  }
  NearestQuery top = at(Vec3(0, 0, -0.19));
  top.turned = true;
  top.axis = Vec3::UnitZ();
  Nearest nearest;
  ASSERT_EQ(nearestOnShape({ShapeKind::kBox, Vec3(0.7, 0.4, 0.2)}, top, nearest), NearestResult::kFound);
  EXPECT_EQ(nearest.point, Vec3(0, 0, 0.2)) << "the bottom is nearer but turned away";
}

/** Of all feet those that no triangle beside theirs is nearer than. */
TEST(Nearest, OtherWaysLeadToWhatIsNearestThere) {
  constexpr double kCosine = 0.9;
  std::mt19937 random(seedOf(5));
  int found = 0;
  for (int round = 0; round < 10; ++round) {
    TestMesh mesh = crumpled(random, 4);
    const MeshView& view = *mesh.view();
    const auto footOn = [&](std::uint32_t t, const Vec3& x) { return nearestOnTriangle(cornersOf(view, t), x).point; };
    const auto touches = [&](std::uint32_t t, const Vec3& point) { return (footOn(t, point) - point).norm() < 1e-7; };
    for (int i = 0; i < 20; ++i) {
      NearestQuery query = at(randomPoint(random, 1.5));
      const Vec3 ways[2] = {randomPoint(random, 1).normalized(), randomPoint(random, 1).normalized()};
      query.ways = ways;
      query.way_count = 2;
      query.cosine = kCosine;
      double least = HUGE_VAL;
      for (std::uint32_t t = 0; t < view.triangle_count; ++t) {
        const Vec3 point = footOn(t, query.x), way = query.x - point;
        bool is_least = way.norm() < least;
        for (const Vec3& other : ways) is_least = is_least && way.dot(other) < kCosine * way.norm();
        for (std::uint32_t beside = 0; is_least && beside < view.triangle_count; ++beside) {
          is_least = !touches(beside, point) || (query.x - footOn(beside, query.x)).norm() > (1 - 1e-6) * way.norm();
        }
        if (is_least) least = way.norm();
      }
      Nearest nearest;
      const bool is_found = nearestOnMesh(view, query, nearest) == NearestResult::kFound;
      ASSERT_EQ(is_found, least < HUGE_VAL);
      if (!is_found) continue;
      ASSERT_NEAR(std::sqrt(nearest.squared_distance), least, 1e-12);
      ++found;
    }
  }
  EXPECT_GT(found, 100);
}

TEST(Nearest, NothingAndTooMuchAreReported) {
  TestMesh empty;
  Nearest nearest;
  NearestQuery query = at(Vec3::Zero());
  EXPECT_EQ(nearestOnMesh(*empty.view(), query, nearest), NearestResult::kNone);
  EXPECT_EQ(nearestOnShape({ShapeKind::kMesh, Vec3::Zero(), nullptr}, query, nearest), NearestResult::kNone);
  EXPECT_EQ(nearestOnShape({}, query, nearest), NearestResult::kNone);
  TestMesh mesh = test::sphereMesh(1, 30);
  query.limit = 20;
  EXPECT_EQ(nearestOnMesh(*mesh.view(), query, nearest), NearestResult::kExhausted);
}

TEST(Nearest, WhereTheLimitIsMetTheNearestOfWhatWasVisitedMayDo) {
  TestMesh mesh = test::sphereMesh(1, 30);
  const MeshView& view = *mesh.view();
  NearestQuery query = at({0.1, 0.2, 0});
  query.nearly = true;
  Nearest exact, nearest;
  ASSERT_EQ(nearestOnMesh(view, query, exact), NearestResult::kFound);
  const std::uint32_t needed = query.work;
  for (std::uint32_t limit = 0; limit < needed; limit += 7) {
    query.work = 0;
    query.limit = limit;
    nearest = {};
    const NearestResult result = nearestOnMesh(view, query, nearest);
    EXPECT_LE(query.work, limit + 255);
    if (limit < 3) {
      EXPECT_EQ(result, NearestResult::kExhausted) << "no triangle has been looked at";
    }
    if (result != NearestResult::kFound) continue;
    EXPECT_GE(nearest.squared_distance, exact.squared_distance);
    EXPECT_NEAR((nearest.point - query.x).squaredNorm(), nearest.squared_distance, 1e-15);
    EXPECT_LT(nearest.point.norm(), 1 + 1e-6);
  }
  EXPECT_GT(nearest.squared_distance, 0);
  query.reach = 0.1;
  query.limit = 5;
  query.work = 0;
  EXPECT_NE(nearestOnMesh(view, query, nearest), NearestResult::kFound) << "nothing is that near";
}

}  // namespace
}  // namespace hapticd
