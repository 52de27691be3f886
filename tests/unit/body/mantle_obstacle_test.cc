// Corners, edges and rims that the mantle of a cylinder or a capsule meets between two of its discs or balls.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "rt/collide/feature.h"
#include "rt/collide/mantle.h"
#include "rt/collide/round.h"
#include "tests/support/random.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::kBlock;
using test::kSpoke;
using test::kStylus;
using test::kTin;
using test::kTub;
using test::TestMesh;

struct Pair {
  const char* name;
  Shape tool, ground;
  int cells;          ///< Of a ground that is a mesh, along an edge of each of its 12 triangles; 0: it is none.
  unsigned seed = 0;  ///< Of a hand under which a place was once told by nobody; 0: of any.
};

void PrintTo(const Pair& pair, std::ostream* out) { *out << pair.name; }

class Mantles : public ::testing::TestWithParam<Pair> {};

/** Wandering over it and turned at random, they sink in nowhere. */
TEST_P(Mantles, AreCarriedBetweenTheirDiscs) {
  const auto& [name, tool, ground, cells, known] = GetParam();
  for (const unsigned seed : known > 0 ? std::vector<unsigned>{known} : seeds(1)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    EXPECT_LT(test::wander({tool, ground, 0, cells, {1.57, 0, 0}}, random).deepest, 150e-6);
  }
}

const Shape kCoin{ShapeKind::kCylinder, {0.03, 0.003, 0}};

INSTANTIATE_TEST_SUITE_P(
    Of, Mantles,
    ::testing::Values(Pair{"AStylusOnABlock", kStylus, kBlock, 0}, Pair{"AStylusOnAMesh", kStylus, kBlock, 1},
                      Pair{"AStylusOnAFineMesh", kStylus, kBlock, 12}, Pair{"AStylusOnATin", kStylus, kTin, 0},
                      Pair{"ASpokeOnABlock", kSpoke, kBlock, 0}, Pair{"ASpokeOnAMesh", kSpoke, kBlock, 1},
                      Pair{"ASpokeOnAFineMesh", kSpoke, kBlock, 12}, Pair{"ATubOnAMesh", kTub, kBlock, 1, 21},
                      Pair{"ACoinOnAMesh", kCoin, kBlock, 1, 21}, Pair{"ACoinOnAFineMesh", kCoin, kBlock, 12, 12},
                      Pair{"ASpokeOnATin", kSpoke, kTin, 0}),
    [](const auto& pair) { return pair.param.name; });

/** Where an edge slips from a cylinder's end over the rim to its mantle, one of both tells it. */
TEST(MantleAndEnd, TellAnEdgeThatSlipsOverTheRim) {
  Random random(2);
  for (int i = 0; i < 3; ++i) (void)random.in(0, 1);
  const test::ToolOnGround pair{kTub, {ShapeKind::kBox, {0.0187198981, 0.0137016416, 0.0053888934}}};
  EXPECT_LT(test::wander(pair, random).deepest, 150e-6);
}

/** From near the place of a rim that is nearest to the axis it is found. */
TEST(MantleTouch, IsWhereARimIsNearest) {
  Random random(1);
  const Shape cylinder{ShapeKind::kCylinder, {0.02, 0.1, 0}}, drum{ShapeKind::kCylinder, {0.03, 0.02, 0}};
  int met = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose X_AE = random.pose(0.05);
    const std::uint32_t part = random.below(2 * kRimParts);
    ObstacleEdge rim;
    ASSERT_TRUE(edgeOfFeature(drum, kFirstRim + part, rim));
    EXPECT_EQ(rim.from, Vec3(0, 0, part < kRimParts ? -0.02 : 0.02));
    const auto apart = [&](double angle) {
      return (X_AE * (rim.from + 0.03 * Vec3(std::cos(angle), std::sin(angle), 0))).head<2>().norm();
    };
    constexpr int kPlaces = 10'000;
    double nearest = 0;
    for (int j = 0; j < kPlaces; ++j) {
      if (const double angle = 2 * EIGEN_PI * j / kPlaces; apart(angle) < apart(nearest)) nearest = angle;
    }
    const double start = nearest + random.in(-0.2, 0.2);
    MantleTouch touch;
    if (meetMantle(cylinder, rim, X_AE, {std::cos(start), std::sin(start), 0}, touch) != MantleMeeting::kMet) continue;
    ++met;
    EXPECT_LE(touch.gap, apart(nearest) - 0.02 + 1e-12) << i;
    EXPECT_GT(touch.gap, apart(nearest) - 0.02 - 1e-5) << i;  // By as much as those places lie apart.
    EXPECT_LT((touch.n + Vec3(touch.x.x(), touch.x.y(), 0).normalized()).norm(), 1e-9);
    EXPECT_NEAR((X_AE.inverse() * touch.x - rim.from).norm(), 0.03, 1e-12);
  }
  EXPECT_GT(met, 500);
}

/** Of a straight edge beyond whose end the axis is nearest, that end is met, or the line of a mesh's edge. */
TEST(MantleTouch, IsWhereAStraightEdgeIsNearest) {
  const Shape cylinder{ShapeKind::kCylinder, {0.02, 0.1, 0}};
  const ObstacleEdge edge{{0.03, -0.01, -0.02}, {0.03, 0.03, 0.02}};
  MantleTouch touch;
  ASSERT_EQ(meetMantle(cylinder, edge, Pose{}, Vec3::Zero(), touch), MantleMeeting::kMet);
  EXPECT_NEAR(touch.t, 0.25, 1e-12);
  EXPECT_NEAR(touch.gap, 0.01, 1e-12);
  EXPECT_LT((touch.x - Vec3(0.03, 0, -0.01)).norm(), 1e-12);
  EXPECT_LT((touch.n - Vec3(-1, 0, 0)).norm(), 1e-12);
  ObstacleEdge beside{{0.03, 0.01, 0}, {0.03, 0.03, 0.02}};
  ASSERT_EQ(meetMantle(cylinder, beside, Pose{}, Vec3::Zero(), touch), MantleMeeting::kMet);
  EXPECT_EQ(touch.t, 0);
  EXPECT_NEAR(touch.gap, std::hypot(0.03, 0.01) - 0.02, 1e-12);
  beside.goes_on = true;
  ASSERT_EQ(meetMantle(cylinder, beside, Pose{}, Vec3::Zero(), touch), MantleMeeting::kMet);
  EXPECT_NEAR(touch.t, -0.5, 1e-12);
  EXPECT_NEAR(touch.gap, 0.01, 1e-12);
  // Along the axis, beyond an end, nearer to an end, and on the axis.
  const auto meets = [&](const Vec3& from, const Vec3& to) {
    return meetMantle(cylinder, {from, to}, Pose{}, Vec3::Zero(), touch);
  };
  EXPECT_EQ(meets({0.03, 0, 0}, {0.031, 0, 0.05}), MantleMeeting::kAlong);
  EXPECT_EQ(meets({0.03, -0.01, 0.101}, {0.03, 0.01, 0.101}), MantleMeeting::kBeyond);
  EXPECT_EQ(meets({0.015, -0.01, 0.096}, {0.015, 0.01, 0.096}), MantleMeeting::kNone);
  EXPECT_EQ(meets({0.015, -0.01, 0.094}, {0.015, 0.01, 0.094}), MantleMeeting::kMet);
  EXPECT_EQ(meets({0, -0.01, 0}, {0, 0.01, 0}), MantleMeeting::kNone);
}

/** Between two answers a touch of a corner is told by where corner and axis are, not by the plane that was found. */
TEST(MantleTouch, FollowsItsCorner) {
  const Shape rod{ShapeKind::kCylinder, {0.01, 0.1, 0}}, box{ShapeKind::kBox, {0.02, 0.02, 0.02}};
  const Pose X_WA{{0.032, 0.021, 0}, Quat::Identity()}, X_WB{};  // Beside that corner, 2 mm apart.
  Touch touch;
  touch.n = Vec3(1, 0, 0);  // As it was when the rod was straight beside it.
  touch.r_a = Vec3(-0.01, 0, 0.02);
  touch.gap = 0.001;
  const Vec3 spin(0, 0, 2);
  rollTo({rod, X_WA}, kFirstBoxCorner + 7, {box, X_WB}, X_WA.p, spin, touch);
  const double apart = std::hypot(0.012, 0.001);
  EXPECT_NEAR(touch.gap, apart - 0.01, 1e-12);
  EXPECT_LT((touch.n - Vec3(0.012, 0.001, 0) / apart).norm(), 1e-12);
  EXPECT_LT((X_WA.p + touch.r_a - (X_WA.p + Vec3(0, 0, 0.02) - 0.01 * touch.n)).norm(), 1e-12);
  EXPECT_LT((touch.moving - spin.cross(touch.r_a - Vec3(-0.01, 0, 0.02))).norm(), 1e-12);
  // What the rod has passed on the other side pushes it back to where it came from.
  Touch behind;
  behind.n = Vec3(-1, 0, 0);
  behind.gap = -0.003;
  rollTo({rod, X_WA}, kFirstBoxCorner + 7, {box, X_WB}, X_WA.p, spin, behind);
  EXPECT_EQ(behind.n, Vec3(-1, 0, 0));
  EXPECT_EQ(behind.gap, -0.003);
}

/** Each number is one corner, edge or rim of a shape that has it, and none of another. */
TEST(MantleTouch, EdgesHaveNumbers) {
  const Shape box{ShapeKind::kBox, {0.01, 0.02, 0.03}}, ball{ShapeKind::kSphere, {0.01, 0, 0}};
  ObstacleEdge edge;
  Vec3 corners = Vec3::Zero(), middles = Vec3::Zero();
  for (std::uint32_t i = 0; i < kBoxCorners; ++i) {
    ASSERT_TRUE(edgeOfFeature(box, kFirstBoxCorner + i, edge));
    EXPECT_TRUE(edge.isCorner());
    EXPECT_EQ(edge.from.cwiseAbs(), box.size);
    corners += (i + 1) * edge.from;
  }
  double length = 0;
  for (std::uint32_t i = 0; i < kBoxEdges; ++i) {
    ASSERT_TRUE(edgeOfFeature(box, kFirstBoxEdge + i, edge));
    EXPECT_FALSE(edge.isCorner() || edge.isRim());
    EXPECT_EQ(edge.to.cwiseAbs(), box.size);
    length += (edge.to - edge.from).norm();
    middles += edge.from + edge.to;
  }
  EXPECT_NEAR(length, 8 * box.size.sum(), 1e-12);
  EXPECT_LT((corners - Vec3(0.04, 0.16, 0.48)).norm(), 1e-12);  // No two are one.
  EXPECT_LT(middles.norm(), 1e-12);
  TestMesh block = test::boxMesh(box.size);
  Shape mesh{ShapeKind::kMesh, Vec3::Zero()};
  mesh.mesh = block.view();
  ASSERT_TRUE(edgeOfFeature(mesh, peakFeature(7), edge));
  EXPECT_TRUE(edge.isCorner());
  EXPECT_FALSE(edgeOfFeature(mesh, peakFeature(8), edge));
  ASSERT_TRUE(edgeOfFeature(mesh, meshEdgeFeature(11, 2), edge));
  EXPECT_EQ(edge.to, mesh.mesh->vertex(11, 0));
  EXPECT_TRUE(edge.goes_on);
  EXPECT_FALSE(edgeOfFeature(mesh, meshEdgeFeature(12, 0), edge));
  EXPECT_EQ(peakFeature(1u << 22), 0u);
  EXPECT_EQ(meshEdgeFeature(1u << 22, 0), 0u);
  for (const std::uint32_t none : {kFirstBoxCorner - 1, kFirstRim, kFirstRidge, kFirstPeak})
    EXPECT_FALSE(edgeOfFeature(box, none, edge)) << none;
  EXPECT_FALSE(edgeOfFeature(ball, kFirstBoxCorner, edge));
  EXPECT_FALSE(edgeOfFeature(mesh, kFirstRidge, edge));
}

}  // namespace
}  // namespace hapticd
