// A client moves a part of a free body: what the part meets and its own body push each other, as if by a motor.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/stepped/rolling_balls.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::object;

constexpr std::uint32_t kCarrier = makeObjectId(40, 1), kCarried = makeObjectId(41, 1), kLoad = makeObjectId(42, 1);
constexpr double kFall = 9.81;
const Vec3 kCrate(0.02, 0.02, 0.02), kOut(0.08, 0, 0);

struct MovedPart {
  MovedPart() {
    house->aim({0.5, 0.5, 0.3});
    house->run(5);
  }
  /** What weighs a ton turns no more than it falls. */
  void addBody(std::uint32_t id, const Vec3& half, const Vec3& at, double mass, bool falls = false) {
    house->send(CommandKind::kAddObject, object(id, ShapeKind::kBox, half, at));
    SetBody order{};
    order.object = id;
    order.mass = mass;
    order.falls = falls ? 1 : 0;
    for (double* i = order.inertia; i < order.inertia + 3; ++i) *i = (mass < 1 ? 3e-4 : 100) * mass;
    house->send(CommandKind::kSetBody, order);
  }
  void addPart(const Vec3& half, const Vec3& at) {
    AddObject part = object(kCarried, ShapeKind::kBox, half, at);
    part.parent = kCarrier;
    house->send(CommandKind::kAddObject, part);
  }
  void put(const Pose& X, const Twist& V) { house->send(CommandKind::kObjectPose, poseMessage(kCarried, X, V)); }
  [[nodiscard]] const RigidBody& body(std::uint8_t k) const { return house->servo->cycle().bodies().body(k).body; }
  [[nodiscard]] const SceneObject& seen(std::uint32_t id) const { return test::seen(*house, id); }

  std::unique_ptr<test::ToolHouse> house = test::houseWithoutFloor();
};

/** By poses at a client's own pace, or by one with a speed: from then on both part at that speed, by momentum. */
TEST(MovedPart, PushesABodyAsFastAsItIsMovedAndItsOwnBodyBack) {
  for (const bool told : {false, true}) {
    MovedPart scene;
    scene.addBody(kCarrier, kCrate, Vec3::Zero(), 0.5);
    scene.addPart(kCrate, kOut);
    scene.addBody(kLoad, kCrate, kOut + Vec3(0.045, 0, 0), 0.2);
    scene.house->run(50);
    const double v = 0.3;
    double deepest = 0;
    if (told) scene.put({kOut, Quat::Identity()}, {Vec3(v, 0, 0), Vec3::Zero()});
    for (int i = 0; i < 100; ++i) {
      if (!told) scene.put({kOut + Vec3(1e-3 * v * (i + 1), 0, 0), Quat::Identity()}, {});
      scene.house->run(1);
      const double gap = scene.seen(kLoad).X_WO.p.x() - scene.seen(kCarried).X_WO.p.x() - 0.04;
      deepest = std::max(deepest, -gap);
      const Vec3 momentum = 0.5 * scene.body(0).twist().v + 0.2 * scene.body(1).twist().v;
      ASSERT_LT(momentum.norm(), 1e-9) << i;
    }
    EXPECT_LT(deepest, 1e-4) << told;
    EXPECT_NEAR(scene.body(1).twist().v.x(), v * 0.5 / 0.7, 2e-3) << told;
    EXPECT_NEAR(scene.body(0).twist().v.x(), -v * 0.2 / 0.7, 2e-3) << told;
  }
}

/** A belt of a table that stands: what lies on it is carried off by friction. */
TEST(MovedPart, CarriesOffWhatLiesOnIt) {
  MovedPart scene;
  scene.house->send(CommandKind::kSetGravity, SetGravity{{0, 0, -kFall}});
  scene.addBody(kCarrier, {0.05, 0.05, 0.05}, Vec3(0, 0, -0.5), 1000);
  scene.addPart({0.3, 0.05, 0.01}, {0, 0, 0.06});
  scene.addBody(kLoad, kCrate, {0, 0, -0.5 + 0.07 + kCrate.z()}, 0.1, true);
  for (const std::uint32_t id : {kCarried, kLoad}) {
    scene.house->send(CommandKind::kObjectMaterial, hd_object_material{id, 0, {1000, 2, 0.5, 0.5}});
  }
  scene.house->run(600);
  ASSERT_TRUE(scene.house->servo->cycle().bodies().body(1).asleep());
  const double v = 0.1, begun = scene.seen(kLoad).X_WO.p.x();
  scene.put({{0, 0, 0.06}, Quat::Identity()}, {Vec3(v, 0, 0), Vec3::Zero()});
  const int ticks = 800;
  for (int i = 0; i < ticks; ++i) scene.house->run(1);
  const double slides = v / (2 * 0.5 * kFall) * v;  // What it stays behind until it is as fast.
  EXPECT_NEAR(scene.seen(kLoad).X_WO.p.x() - begun, v * 1e-3 * ticks - slides, 1e-3);
  EXPECT_NEAR(scene.body(1).twist().v.x(), v, 1e-4);
  EXPECT_NEAR(scene.body(0).twist().v.x(), -v * 0.1 / 1000, 1e-6);
}

/** Its origin stands, and the rest of it sleeps. */
TEST(MovedPart, WakesWhatLiesOnItWhereItBeginsToTurn) {
  MovedPart scene;
  scene.house->send(CommandKind::kSetGravity, SetGravity{{0, 0, -kFall}});
  scene.addBody(kCarrier, {0.05, 0.05, 0.05}, Vec3(0, 0, -0.5), 1000);
  scene.addPart({0.1, 0.1, 0.01}, {0, 0, 0.06});
  scene.addBody(kLoad, {0.01, 0.01, 0.01}, {0.06, 0, -0.5 + 0.08}, 0.1, true);
  scene.house->run(600);
  ASSERT_TRUE(scene.house->servo->cycle().bodies().body(1).asleep());
  const double w = 0.5;
  scene.put({{0, 0, 0.06}, Quat::Identity()}, {Vec3::Zero(), Vec3(0, 0, w)});
  scene.house->run(300);
  EXPECT_NEAR(scene.body(1).twist().v.y(), w * 0.06 * std::cos(w * 0.3), 3e-3);
}

/** The hand feels what pushes its tool, and that is no debt of the wall's. */
TEST(MovedPart, PushesAToolWithinItsBooks) {
  for (const bool direct : {false, true}) {
    MovedPart scene;
    test::ToolHouse& house = *scene.house;
    AttachTool tool = house.tool();
    if (direct) tool.flags |= kToolDirect;
    house.aim({0, 0, 0.1});
    house.hold(tool);
    house.run(500);
    scene.addBody(kCarrier, {0.05, 0.05, 0.05}, Vec3(0, 0, 0.3), 1000);
    scene.addPart({0.05, 0.05, 0.02}, {0, 0, -0.1});
    house.run(20);
    scene.put({{0, 0, -0.1}, Quat::Identity()}, {Vec3(0, 0, -0.15), Vec3::Zero()});
    double strongest = 0, least = 0;
    for (int i = 0; i < 700; ++i) {
      house.run(1);
      strongest = std::max(strongest, -house.sent.back().force.z());
      least = std::min(least, house.out().guard.energy);
    }
    EXPECT_GT(strongest, 0.5) << direct;
    EXPECT_GT(least, -1e-3) << direct;
  }
}

}  // namespace
}  // namespace hapticd
