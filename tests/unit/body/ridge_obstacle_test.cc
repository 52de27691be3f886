// Ridges and peaks of a mesh in the scene that a tool meets between its points.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include "rt/collide/edge_search.h"
#include "tests/support/random.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/signed_gap.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::kFloor;
using test::kTool;
using test::kWall;
using test::object;
using test::TestMesh;
using House = test::ToolHouse;

/** A closed surface of 8 n^2 triangles that is seen whole from its middle, as far from it as `radius` says. */
TestMesh starMesh(int n, const std::function<double(const Vec3&)>& radius) {
  TestMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> known;
  for (int octant = 0; octant < 8; ++octant) {
    const int sign[3] = {(octant & 1) != 0 ? -1 : 1, (octant & 2) != 0 ? -1 : 1, (octant & 4) != 0 ? -1 : 1};
    const bool flip = sign[0] * sign[1] * sign[2] < 0;
    const auto corner = [&](int i, int j) {
      const std::array<int, 3> at{i * sign[0], j * sign[1], (n - i - j) * sign[2]};
      const auto seen = known.find(at);
      if (seen != known.end()) return seen->second;
      const Vec3 u = Vec3(at[0], at[1], at[2]).normalized();
      return known[at] = mesh.addVertex(radius(u) * u);
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      mesh.addTriangle(a, flip ? c : b, flip ? b : c);
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j + 2 <= n) add(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
    }
  }
  mesh.flags = HD_MESH_CLOSED;
  return mesh;
}

/** A mesh's edges against the tool, and the tool's, or its axis, against the mesh, in many places. */
double leastGap(const Shape& tool, const Pose& X_WT, const Shape& ground, const Pose& X_WG) {
  constexpr int kParts = 8, kPlaces = 200;
  constexpr double kReach = 0.05;
  const Pose X_TG = X_WT.inverse() * X_WG, X_GT = X_TG.inverse();
  double least = INFINITY;
  for (std::uint32_t t = 0; t < ground.mesh->triangle_count; ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = X_TG * ground.mesh->vertex(t, k), b = X_TG * ground.mesh->vertex(t, (k + 1) % 3);
      if (a.norm() > tool.size.norm() + tool.size.x() + (b - a).norm()) continue;
      for (int j = 0; j < kParts; ++j) least = std::min(least, test::signedGap(tool, a + (b - a) * (1.0 * j / kParts)));
    }
  }
  const double radius = tool.kind == ShapeKind::kCapsule ? tool.size.x() : 0;
  const auto add = [&](const Vec3& x) { least = std::min(least, test::signedGap(ground, X_GT * x, kReach) - radius); };
  for (int j = 0; j <= kPlaces; ++j) {
    const double t = 2.0 * j / kPlaces - 1;
    if (tool.kind == ShapeKind::kBox) {
      test::onBoxEdges(tool.size, t, add);
    } else if (tool.kind == ShapeKind::kCapsule) {
      add({0, 0, t * tool.size.y()});
    } else {
      for (int i = 0; i <= 20; ++i) {
        const double z = tool.size.y() * (0.1 * i - 1);
        add({tool.size.x() * std::cos(double(EIGEN_PI) * t), tool.size.x() * std::sin(double(EIGEN_PI) * t), z});
      }
    }
  }
  return least;
}

struct Ground {
  const char* name;
  int n;        ///< As in starMesh().
  bool jagged;  ///< Each vertex for itself, or waves.
};

void PrintTo(const Ground& ground, std::ostream* out) { *out << ground.name; }

class RidgeObstacles : public ::testing::TestWithParam<Ground> {};

/** Tools of every shape, pressed on it and turned, do not sink in. */
TEST_P(RidgeObstacles, CarryToolsBetweenTheirPoints) {
  for (const unsigned seed : seeds(4)) {
    std::mt19937 random(seed);
    const auto u = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
    const double radius = u(0.02, 0.04), rough = u(0.1, 0.3);
    TestMesh mesh = starMesh(GetParam().n, [&](const Vec3& d) {
      const double wave = 0.3 * std::sin(9 * d.x()) * std::sin(8 * d.y() + 1) * std::sin(7 * d.z() + 2);
      return radius * (1 + rough * (GetParam().jagged ? u(-0.5, 0.5) : wave));
    });
    for (int kind = 0; kind < 4; ++kind) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", tool " + std::to_string(kind));
      const Vec3 half(u(0.01, 0.03), u(0.01, 0.03), u(0.005, 0.01));
      const Shape tool = kind < 2    ? Shape{ShapeKind::kBox, half}
                         : kind == 2 ? Shape{ShapeKind::kCapsule, {0.3 * half.x(), half.y(), 0}}
                                     : Shape{ShapeKind::kCylinder, {0.6 * half.x(), half.y(), 0}};
      House house;
      TestMesh block = test::boxMesh(half);
      house.meshes.publish(3, block.view());
      house.meshes.publish(4, mesh.view());
      house.send(CommandKind::kObjectPose, hd_object_pose{kFloor, 0, {0, 0, -1}, {1, 0, 0, 0}, {}, {}});
      kind == 1 ? house.reshape(ShapeKind::kMesh, Vec3::Zero(), 3) : house.reshape(tool.kind, tool.size);
      Shape ground{ShapeKind::kMesh, Vec3::Zero()};
      ground.mesh = mesh.view();
      const Pose X_WG{{u(-0.005, 0.005), u(-0.005, 0.005), -1.25 * radius},
                      fromRotationVector({u(-2, 2), u(-2, 2), u(-2, 2)})};
      AddObject obstacle = object(kWall, ShapeKind::kMesh, Vec3::Zero(), X_WG.p);
      obstacle.shape.mesh = 4;
      store(X_WG.q, obstacle.q);
      house.aim({0, 0, 0.08});
      house.run(300);
      house.send(CommandKind::kAddObject, obstacle);
      house.hold();
      const Vec3 turn(u(-0.2, 0.2), u(-0.2, 0.2), u(-0.2, 0.2));
      double deepest = 0;
      bool touched = false;
      for (int i = 0; i < 1200; ++i) {
        const double t = 1e-3 * i;
        house.aim({0.003 * std::sin(2 * t), 0.003 * std::sin(3 * t), std::max(0.08 - 0.15 * t, -0.01)},
                  std::sin(4 * t) * turn);
        house.run(1);
        touched = touched || house.servo->cycle().tool(0).last().touching > 0;
        if (touched && i % 60 == 0) deepest = std::max(deepest, -leastGap(tool, house.place(), ground, X_WG));
      }
      EXPECT_TRUE(touched);
      EXPECT_LT(deepest, 60e-6);
    }
  }
}

double deepestOn(const Vec3& half, int tool_parts, int ground_parts, const Vec3& first_turn, unsigned seed) {
  Random random(seed);
  const Vec3 ground(random.in(0.01, 0.03), random.in(0.01, 0.03), random.in(0.005, 0.02));
  const test::ToolOnGround pair{
      {ShapeKind::kBox, half}, {ShapeKind::kBox, ground}, tool_parts, ground_parts, first_turn};
  return test::wander(pair, random).deepest;
}

/** Straight edges hold in one part or many, of boxes too, aslant as across; where parts meet nothing is caught. */
class StraightRidges : public ::testing::TestWithParam<int> {};

TEST_P(StraightRidges, CarryABoxOnABox) {
  for (const unsigned seed : seeds(1)) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    EXPECT_LT(deepestOn({0.01, 0.02, 0.005}, 0, GetParam(), Vec3::Zero(), seed), 250e-6);
  }
}

/** Where a rod's edge crosses it is told, not the nearest end of a part: there the normal is another. */
TEST(StraightRidgeInParts, CarriesARodOfAMeshWhereTheirEdgesCross) {
  EXPECT_LT(deepestOn({0.002, 0.002, 0.06}, 1, 12, {1.57, 0, 0}, 3), 150e-6);
}

/** Of what lies along an edge, aslant, both ends are told that touch, though the nearest is far deeper. */
TEST(TouchingSpan, EndsWhereTheEdgeIsApart) {
  constexpr double kLength = 0.04, kWithin = 2e-4;  // Asked so far within the edge [m].
  const Vec3 n(0, 0, 1);
  const auto gap = [&](double t) { return -1.5e-4 + 2e-4 * t; };  // Of the edge itself: apart from 0.75 on.
  const auto asked = [&](double t) { return gap(t) + kWithin; };
  const EdgeSpan span = touchingSpan(0.002, kAslant, kLength, -kWithin * n, asked, [&](double) { return n; });
  ASSERT_TRUE(span.near);
  EXPECT_EQ(span.place[0], 0);
  EXPECT_NEAR(span.place[2], 0.75, 2e-3);
}

/** Of an edge that lies on a face, both ends are told where that face's normal still is: beyond, none of it would be.
 */
TEST(TouchingSpan, EndsWhereTheFaceDoes) {
  constexpr double kLength = 0.04, kWithin = 2e-4, kFaceEnds = 0.6;
  const auto beyond = [](double t) { return kLength * std::max(0.0, t - kFaceEnds); };
  double asked = 0;
  const auto gap = [&](double t) {
    asked = t;
    return std::hypot(beyond(t), kWithin);
  };
  const auto normal = [&](double) { return Vec3(-beyond(asked), 0, kWithin).normalized(); };
  const EdgeSpan span = touchingSpan(0.002, kAslant, kLength, Vec3(0, 0, -kWithin), gap, normal);
  ASSERT_TRUE(span.near);
  EXPECT_EQ(span.place[1], 0);
  EXPECT_NEAR(span.place[2], kFaceEnds, 1e-3);
  (void)gap(span.place[2]);
  EXPECT_GT(normal(0).z(), SceneContacts::kSameWay);
}

/** Where edges cross, one place is told: those beside it, within reach of the same touch, have normals that are turned.
 */
TEST(TouchingSpan, IsOnePlaceWhereEdgesCross) {
  constexpr double kLength = 0.04, kWithin = 2e-4, kCross = 0.3;
  double asked = 0;
  const auto gap = [&](double t) {
    asked = t;
    return std::hypot(kLength * (t - kCross), kWithin);
  };
  const auto normal = [&](double) { return Vec3(kLength * (kCross - asked), 0, kWithin).normalized(); };
  const EdgeSpan span = touchingSpan(0.002, kAslant, kLength, Vec3(0, 0, -kWithin), gap, normal);
  ASSERT_TRUE(span.near);
  EXPECT_NEAR(span.place[0], kCross, 1e-4);
  EXPECT_FALSE(span.has(1) || span.has(2));
}

INSTANTIATE_TEST_SUITE_P(Of, StraightRidges, ::testing::Values(0, 1, 12), [](const auto& parts) {
  return parts.param == 0 ? std::string("ABox") : "AMeshOf" + std::to_string(12 * parts.param * parts.param);
});

INSTANTIATE_TEST_SUITE_P(On, RidgeObstacles,
                         ::testing::Values(Ground{"ACrystal", 4, true}, Ground{"Thorns", 12, true},
                                           Ground{"CoarseHills", 8, false}, Ground{"FineHills", 28, false}),
                         [](const auto& ground) { return ground.param.name; });

}  // namespace
}  // namespace hapticd
