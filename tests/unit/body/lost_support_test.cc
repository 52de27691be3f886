// Bodies that sleep, of what holds them one thing goes or holds less, and the rest stays.
#include <gtest/gtest.h>

#include <cmath>

#include "rt/cycle/free_bodies.h"
#include "tests/support/stepped/rolling_balls.h"

namespace hapticd {
namespace {

using test::body;
using test::gravity;
using test::kOther;
using test::kRolled;
using test::object;
using test::seen;

constexpr std::uint32_t kThird = makeObjectId(20, 1);

void addBrick(test::ToolHouse& house, const Vec3& half, const Vec3& at, const Quat& q = Quat::Identity()) {
  AddObject brick = object(kRolled, ShapeKind::kBox, half, at);
  store(q, brick.q);
  house.send(CommandKind::kAddObject, brick);
  SetBody order = body(kRolled, 0.2);
  const Mat3 inertia = MassProperties::ofBox(order.mass, 2 * half).inertia_O;
  for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
  house.send(CommandKind::kSetBody, order);
}

/** A plank on two blocks, asleep. */
struct Bridge : test::ToolHouse {
  Bridge() {
    for (const auto& [id, x] : {std::pair{kOther, -0.08}, {kThird, 0.08}}) {
      send(CommandKind::kAddObject, object(id, ShapeKind::kBox, {0.02, 0.02, 0.02}, {x, 0.3, 0.3}));
    }
    addBrick(*this, {0.1, 0.02, 0.005}, {0, 0.3, 0.325});
    gravity(*this, 9.81);
    run(1000);
    EXPECT_TRUE(servo->cycle().bodies().body(0).asleep());
    EXPECT_NEAR(seen(*this, kRolled).X_WO.p.z(), 0.325, 1e-4);
  }
  bool falls() {
    run(100);
    return seen(*this, kRolled).X_WO.p.z() < 0.32;
  }
};

TEST(FreeBodies, APlankFallsWhenOneOfTwoBlocksBelowItGoes) {
  Bridge removed;
  removed.send(CommandKind::kRemoveObject, ObjectRef{kThird});
  EXPECT_TRUE(removed.falls());
  Bridge disabled;
  disabled.send(CommandKind::kObjectFlags, hd_object_flags{kThird, HD_OBJECT_ENABLED, 0, 0});
  EXPECT_TRUE(disabled.falls());
  Bridge put;
  put.send(CommandKind::kObjectPose, hd_object_pose{kThird, 0, {0.5, 0.5, 0.5}, {1}, {}, {}});
  EXPECT_TRUE(put.falls());
  Bridge stays;
  const Vec3 lies = seen(stays, kRolled).X_WO.p;
  stays.run(300);
  EXPECT_EQ(seen(stays, kRolled).X_WO.p, lies);
}

/** The wall holds nothing, before and after. */
TEST(FreeBodies, OneOnASlopeBesideASmoothWallSlidesWhenTheSlopeHoldsItNoMore) {
  const Quat steep = fromRotationVector({0, 0.3, 0});
  test::ToolHouse house;
  AddObject slope = object(kOther, ShapeKind::kBox, {0.5, 0.1, 0.01}, {0, 0.5, 0.3});
  store(steep, slope.q);
  house.send(CommandKind::kAddObject, slope);
  AddObject wall = object(kThird, ShapeKind::kBox, {0.5, 0.01, 0.1}, {0, 0.53, 0.3});
  store(steep, wall.q);
  wall.material = {1000, 0, 0, 0};
  house.send(CommandKind::kAddObject, wall);
  addBrick(house, Vec3::Constant(0.02), Vec3(0, 0.5, 0.3) + steep * Vec3(0, 0, 0.03), steep);
  house.run(20);
  gravity(house, 9.81);
  house.run(1000);
  ASSERT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  const Vec3 from = seen(house, kRolled).X_WO.p;
  house.send(CommandKind::kObjectMaterial, hd_object_material{kOther, 0, {1000, 0, 0, 0}});
  house.run(300);
  EXPECT_GT((seen(house, kRolled).X_WO.p - from).norm(), 0.05);
}

}  // namespace
}  // namespace hapticd
