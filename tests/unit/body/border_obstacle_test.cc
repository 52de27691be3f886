// The border of an open mesh meets a tool's faces, where none of the tool's points comes near.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

constexpr double kSheetHalf = 0.05;  ///< Of the upright sheet that ends at z = 0: half its length, and its height [m].

/** How deep the sheet's upper border gets in the tool while a hand presses and slides that on it. */
double borderIn(const Shape& tool, bool as_mesh, bool turned) {
  Random random(1);
  const Quat q_WS = fromRotationVector(random.vector(0.1) + Vec3(0, 0, turned ? EIGEN_PI : 0));
  test::TestMesh sheet, held = test::boxMesh(tool.size);
  const auto corner = [&](double y, double z) { return sheet.addVertex(q_WS * Vec3(0, y, z)); };
  sheet.addQuad(corner(-kSheetHalf, -kSheetHalf), corner(kSheetHalf, -kSheetHalf), corner(kSheetHalf, 0),
                corner(-kSheetHalf, 0));
  const auto house = test::houseWithoutFloor();
  house->meshes.publish(3, held.view());
  house->meshes.publish(4, sheet.view());
  as_mesh ? house->reshape(ShapeKind::kMesh, Vec3::Zero(), 3) : house->reshape(tool.kind, tool.size);
  Vec3 hand(0, 0, 0.06), to = Vec3::Zero(), turn = Vec3::Zero();
  house->aim(hand);
  house->run(500);
  AddObject wall = test::object(test::kWall, ShapeKind::kMesh, Vec3::Zero(), Vec3::Zero());
  wall.shape.mesh = 4;
  wall.material = {1000, 0, 0, 0};
  house->send(CommandKind::kAddObject, wall);
  house->hold();
  double deepest = 0;
  int touched = 0;
  for (int i = 0; i < 2000; ++i) {
    if (i % 300 == 0) to = Vec3(0, 0, -0.01) + random.vector(0.003);
    hand += 0.004 * (to - hand);
    turn += random.vector(0.001);
    house->aim(hand, turn);
    house->run(1);
    touched += house->servo->cycle().tool(0).last().touching > 0;
    for (int k = -50; k <= 50; ++k) {
      const Vec3 x = house->place().inverse() * (q_WS * Vec3(0, 0.02 * k * kSheetHalf, 0));
      deepest = std::max(deepest, -test::signedGap(tool, x));
    }
  }
  EXPECT_GT(touched, 1000);
  return deepest;
}

/** A brick came down over it as if it were not there: it went between the points of its face. */
TEST(Borders, OfASheetHoldAFace) {
  const Shape plug{ShapeKind::kBox, {0.01, 0.01, 0.03}};
  for (const bool turned : {false, true}) {
    EXPECT_LT(borderIn(test::kBrick, false, turned), 5e-5) << turned;
    EXPECT_LT(borderIn(test::kBrick, true, turned), 5e-5) << "as a mesh " << turned;
    EXPECT_LT(borderIn(plug, false, turned), 5e-5) << turned;
    EXPECT_LT(borderIn(test::kTub, false, turned), 5e-5) << turned;
  }
}

}  // namespace
}  // namespace hapticd
