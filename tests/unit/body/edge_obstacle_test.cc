// Edges, corners and rims of the scene that a tool meets between its points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/shape/signed_gap.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::kWall;
using test::object;
using House = test::ToolHouse;

/** Of both, every edge in many places against the other: whichever lies deepest, one of its edges does. */
double gapOf(const Shape& one, const Pose& X_1, const Shape& other, const Pose& X_2) {
  constexpr int kPlaces = 2000;
  double least = INFINITY;
  const auto add = [&](const Pose& X, const Shape& to, const Pose& X_to, const Vec3& x) {
    least = std::min(least, test::signedGap(to, X_to.inverse() * (X * x)));
  };
  const auto all = [&](const Shape& of, const Pose& X, const Shape& to, const Pose& X_to) {
    for (int j = 0; j <= kPlaces; ++j) {
      const double t = 2.0 * j / kPlaces - 1;
      if (of.kind == ShapeKind::kCylinder) {
        const Vec3 rim = of.size.x() * Vec3(std::cos(EIGEN_PI * t), std::sin(EIGEN_PI * t), 0);
        for (const double z : {-of.size.y(), of.size.y()}) add(X, to, X_to, rim + Vec3(0, 0, z));
        continue;
      }
      test::onBoxEdges(of.size, t, [&](const Vec3& x) { add(X, to, X_to, x); });
    }
  };
  all(one, X_1, other, X_2);
  all(other, X_2, one, X_1);
  return least;
}

struct ToolOnEdge {
  const char* name;
  Shape tool, obstacle;
  Vec3 tool_turn, obstacle_turn;
  double top;  ///< Of the obstacle above its middle [m].
};

void PrintTo(const ToolOnEdge& crossing, std::ostream* out) { *out << crossing.name; }

class EdgeObstacles : public ::testing::TestWithParam<ToolOnEdge> {};

/** A tool that is pressed on it lies still, no deeper than it is let be. */
TEST_P(EdgeObstacles, CarryAToolBetweenItsPoints) {
  const ToolOnEdge& crossing = GetParam();
  for (int meshes = 0; meshes < 4; ++meshes) {
    const bool mesh = (meshes & 1) != 0, on_mesh = (meshes & 2) != 0;
    if (mesh && crossing.tool.kind != ShapeKind::kBox) continue;
    if (on_mesh && crossing.obstacle.kind != ShapeKind::kBox) continue;
    SCOPED_TRACE(std::string(mesh ? "as a mesh" : "as a primitive") + (on_mesh ? " on a mesh" : ""));
    House house;
    test::TestMesh block = test::boxMesh(crossing.tool.size);
    house.meshes.publish(3, block.view());
    mesh ? house.reshape(ShapeKind::kMesh, Vec3::Zero(), 3) : house.reshape(crossing.tool.kind, crossing.tool.size);
    const Pose X_WO{{0.0013, 0.0017, 0.03 - crossing.top}, fromRotationVector(crossing.obstacle_turn)};
    test::TestMesh ground = test::boxMesh(crossing.obstacle.size);
    house.meshes.publish(4, ground.view());
    AddObject obstacle = object(kWall, crossing.obstacle.kind, crossing.obstacle.size, X_WO.p);
    if (on_mesh) obstacle.shape = {static_cast<std::uint32_t>(ShapeKind::kMesh), 4, {}};
    store(X_WO.q, obstacle.q);
    house.send(CommandKind::kAddObject, obstacle);
    house.aim({0, 0, 0.08}, crossing.tool_turn);
    house.run(800);
    house.hold();
    house.aim({0, 0, 0.03}, crossing.tool_turn);
    house.run(1500);
    Vec3 least = house.place().p, most = least;
    double deepest = 0;
    for (int i = 0; i < 500; ++i) {
      house.run(1);
      least = least.cwiseMin(house.place().p);
      most = most.cwiseMax(house.place().p);
      ASSERT_GT(house.servo->cycle().tool(0).last().contact.force.z(), 0.3) << i;
      if (i % 100 == 0) {
        deepest = std::max(deepest, -gapOf(crossing.tool, house.place(), crossing.obstacle, X_WO));
      }
    }
    EXPECT_LT(deepest, 1.1 * Tool::kSlop);
    EXPECT_LT((most - least).norm(), 2e-6);
  }
}

const Shape kSlab{ShapeKind::kBox, {0.04, 0.03, 0.005}}, kDrum{ShapeKind::kCylinder, {0.03, 0.01, 0}};
const Shape kCube{ShapeKind::kBox, {0.003, 0.003, 0.003}}, kPeg{ShapeKind::kCylinder, {0.003, 0.01, 0}};
const Shape kRoll{ShapeKind::kCylinder, {0.03, 0.04, 0}};
const Shape kBeam{ShapeKind::kBox, {0.005, 0.03, 0.005}};
const Shape kBar{ShapeKind::kBox, {0.05, 0.004, 0.004}};
const double kEighth = EIGEN_PI / 4;

INSTANTIATE_TEST_SUITE_P(
    Lies, EdgeObstacles,
    ::testing::Values(ToolOnEdge{"SlabOnCube", kSlab, kCube, {0, 0, 0}, {0, 0, 0}, 0.003},
                      ToolOnEdge{"TiltedSlabOnCube", kSlab, kCube, {0.1, 0.15, 0}, {0, 0, 0}, 0.003},
                      ToolOnEdge{"SlabOnPeg", kSlab, kPeg, {0, 0, 0.3}, {0, 0, 0}, 0.01},
                      ToolOnEdge{"TiltedSlabOnPeg", kSlab, kPeg, {0.2, 0.1, 0.3}, {0, 0, 0}, 0.01},
                      ToolOnEdge{"SlabOnCorner", kSlab, kCube, {0, 0, 0}, {0.6155, kEighth, 0}, 0.0052},
                      ToolOnEdge{"SlabOnRidge", kSlab, kBar, {0, 0, 0.4}, {kEighth, 0, 0}, 0.00566},
                      ToolOnEdge{"EdgeAcrossRidge", kBeam, kBar, {0, kEighth, 0.3}, {kEighth, 0, 0}, 0.00566},
                      ToolOnEdge{"DrumOnCube", kDrum, kCube, {0, 0, 0}, {0, 0, 0}, 0.003},
                      ToolOnEdge{"DrumOnPeg", kDrum, kPeg, {0.1, 0, 0}, {0, 0, 0}, 0.01},
                      ToolOnEdge{"RimAcrossRidge", kDrum, kBar, {0.1, 1.1, 0.1}, {kEighth, 0, 0}, 0.00566},
                      ToolOnEdge{"SteepRimAcrossRidge", kDrum, kBar, {0.15, 1.4, 0.1}, {kEighth, 0, 0}, 0.00566},
                      ToolOnEdge{"MantleAcrossRidge", kRoll, kBar, {-0.664, 1.424, 0}, {kEighth, 0, 0}, 0.00566},
                      ToolOnEdge{"MantleOnCorner", kRoll, kCube, {-0.664, 1.424, 0}, {0.6155, kEighth, 0}, 0.0052}),
    [](const auto& crossing) { return crossing.param.name; });

/** A rim that comes out of the tool's face at its border may go in again not far on, where its corner is. */
TEST(RimObstacle, IsMetInEachPlace) {
  Random random(6);
  const test::ToolOnGround pair{{ShapeKind::kBox, {0.01, 0.02, 0.005}},
                                {ShapeKind::kCylinder, {0.0278572029, 0.0099796971, 0}},
                                1,
                                0,
                                Vec3::Zero(),
                                0.4};
  for (int i = 0; i < 3; ++i) (void)random.in(0, 1);
  EXPECT_LT(test::wander(pair, random).deepest, 150e-6);
}

}  // namespace
}  // namespace hapticd
