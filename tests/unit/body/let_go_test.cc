// What no hand holds any more is where it was let go of, whatever else it becomes in that tick.
#include <gtest/gtest.h>

#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kTool;
using test::kWall;
using test::object;
using House = test::ToolHouse;

/** Of what has no mass: it does not go on with the speed of the hand. */
TEST(HeldTool, WhatIsLetGoOfStaysThere) {
  enum class LetGo { kPutAway, kForAnother };
  for (const LetGo how : {LetGo::kPutAway, LetGo::kForAnother}) {
    House house;
    house.send(CommandKind::kAddObject, object(kWall, ShapeKind::kSphere, {0.01, 0, 0}, {0.5, 0.5, 0}));
    house.hold();
    for (int i = 0; i < 200; ++i) {
      house.aim({3e-4 * i, 0, 0.04}, Vec3(0, 0, 1e-3 * i));
      house.run(1);
    }
    const auto seen = [&]() -> const SceneObject& { return *house.servo->cycle().scene().find(kTool); };
    ASSERT_GT(seen().V_WO.v.x(), 0.1);
    const std::uint32_t edits = seen().client_edits[SceneObject::kPlace];
    const Pose let_go = seen().X_WO;
    AttachTool other = house.tool();
    other.object = kWall;
    how == LetGo::kPutAway ? house.send(CommandKind::kDetachTool, DeviceRef{0})
                           : house.send(CommandKind::kAttachTool, other);
    house.run(500);
    EXPECT_LT((seen().X_WO.p - let_go.p).norm(), 1e-3) << static_cast<int>(how);
    EXPECT_LT(seen().X_WO.q.angularDistance(let_go.q), 0.01);
    EXPECT_TRUE(seen().V_WO.v.isZero(0));
    EXPECT_GT(seen().client_edits[SceneObject::kPlace], edits) << "so that control and other groups learn it";
  }
}

/** Let go of and made no body in the same tick, before it flies on as one. */
TEST(HeldTool, WhatIsLetGoOfAndHasNoMassAnyMoreStaysThere) {
  for (const bool as_plane : {false, true}) {
    House house;
    SetBody body{};
    body.object = kTool;
    body.mass = 0.2;
    for (const int i : {0, 1, 2}) body.inertia[i] = 1e-5;
    house.send(CommandKind::kSetBody, body);
    house.hold();
    for (int i = 0; i < 200; ++i) {
      house.aim({3e-4 * i, 0, 0.04});
      house.run(1);
    }
    const auto seen = [&]() -> const SceneObject& { return *house.servo->cycle().scene().find(kTool); };
    ASSERT_GT(seen().V_WO.v.x(), 0.1);
    const Vec3 let_go = seen().X_WO.p;
    house.send(CommandKind::kDetachTool, DeviceRef{0});
    if (as_plane) {
      house.send(CommandKind::kSetShape, SetShape{kTool, 0, {static_cast<std::uint32_t>(ShapeKind::kPlane), 0, {}}});
      house.run(1);
    }
    body.mass = 0;
    house.send(CommandKind::kSetBody, body);
    house.run(300);
    EXPECT_LT((seen().X_WO.p - let_go).norm(), 1e-3) << as_plane;
    EXPECT_TRUE(seen().V_WO.v.isZero(0)) << as_plane;
  }
}

}  // namespace
}  // namespace hapticd
