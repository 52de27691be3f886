// What a body touches jumps, or is gone and another stands in its slot: until an answer has seen that, contacts with it
// are planes in a frame that is elsewhere.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::object;

constexpr std::uint32_t kBelow = makeObjectId(40, 1), kNext = makeObjectId(40, 2), kOnTile = makeObjectId(21, 1),
                        kTaken = makeObjectId(22, 1);
constexpr double kPull = 9.81, kStep = 1e-3;
const Vec3 kTileHalf(0.05, 0.05, 0.01), kUnder(0.1, 0, -0.01), kTileLoad(0.01, 0.01, 0.005), kOn(0.1, 0, 0.005);

/** A brick on a slab; `later`: so many ticks, for answers come every second one. */
struct Lying {
  Lying(int later, bool slab_moves) {
    house->aim({0.5, 0.5, 0.3});
    house->run(5 + later);
    house->send(CommandKind::kSetGravity, SetGravity{{0, 0, -kPull}});
    house->send(CommandKind::kAddObject, object(kOnTile, ShapeKind::kBox, kTileLoad, kOn));
    setFree(kOnTile, 0.01, true);
    house->send(CommandKind::kAddObject, object(kBelow, ShapeKind::kBox, kTileHalf, kUnder));
    if (slab_moves) setFree(kBelow, 1000, false);
    house->run(slab_moves ? 60 : 400);
  }
  void setFree(std::uint32_t id, double mass, bool falls) {
    SetBody order{};
    order.object = id;
    order.falls = falls ? 1 : 0;
    order.mass = mass;
    for (double* i = order.inertia; i < order.inertia + 3; ++i) *i = 1e-4 * mass;
    house->send(CommandKind::kSetBody, order);
  }
  void jump(const Vec3& to, const Twist& V = {}) {
    house->send(CommandKind::kObjectPose, poseMessage(kBelow, {to, Quat::Identity()}, V));
  }
  void replace(const Vec3& at) {
    house->send(CommandKind::kRemoveObject, ObjectRef{kBelow});
    house->send(CommandKind::kAddObject, object(kNext, ShapeKind::kBox, kTileHalf, at));
  }
  [[nodiscard]] const FreeBody& brick() const { return house->servo->cycle().bodies().body(0); }
  /** It falls from now on, as if nothing had ever been there. */
  void expectFall(const std::string& what) {
    const Twist before = brick().body.twist();
    for (int i = 1; i <= 12; ++i) {
      house->run(1);
      const Twist& V = brick().body.twist();
      ASSERT_LT((V.v - before.v - Vec3(0, 0, -kPull * kStep * i)).norm(), 1e-9) << what << ", tick " << i;
      ASSERT_LT((V.w - before.w).norm(), 1e-7) << what << ", tick " << i;
    }
  }

  std::unique_ptr<test::ToolHouse> house = test::houseWithoutFloor();
};

/** It was thrown at 5 m/s: the speed of what turns 0.5 m away, where it would be here. */
TEST(JumpedObstacle, ThrowsNothingThatLayOnIt) {
  const Twist turns{Vec3::Zero(), Vec3(0, 10, 0)};
  for (int later = 0; later < 2; ++later) {
    for (const Vec3& to : {Vec3(0.6, 0, kUnder.z()), Vec3(0.1, 0, 0.4), Vec3(-0.4, 0.3, kUnder.z() - 0.1)}) {
      for (const bool again : {false, true}) {
        Lying scene(later, false);
        ASSERT_NEAR(scene.brick().body.com().z(), kOn.z(), 1e-5);
        again ? scene.replace(to) : scene.jump(to, turns);
        if (again) scene.house->send(CommandKind::kObjectPose, poseMessage(kNext, {to, Quat::Identity()}, turns));
        if (to.z() != kUnder.z()) {
          scene.expectFall("jumped");
          continue;
        }
        for (int i = 0; i < 12; ++i) {  // At one height it holds until an answer has seen that it is gone.
          scene.house->run(1);
          ASSERT_LT(scene.brick().body.twist().v.z(), 1e-6) << "tick " << i;
        }
        EXPECT_LT(scene.brick().body.twist().v.z(), -kPull * kStep * 6);
      }
    }
  }
}

/** A body that is put elsewhere, or another in its slot, does not push either. */
TEST(JumpedObstacle, ABodyThatIsPutElsewherePushesNothing) {
  for (int later = 0; later < 2; ++later) {
    for (const bool again : {false, true}) {
      Lying scene(later, true);
      const Vec3 to(0.1, 0, 0.4);
      again ? scene.replace(to) : scene.jump(to);
      if (again) scene.setFree(kNext, 1000, false);
      scene.expectFall(again ? "replaced" : "put elsewhere");
      EXPECT_LT((scene.house->servo->cycle().bodies().body(1).body.com() - to).norm(), 1e-9);
    }
  }
}

/** Nor where it turns, and stands so that the old plane still fits: it threw the brick at 4.9 m/s. */
TEST(JumpedObstacle, ABodyThatIsPutElsewhereAndTurnsThrowsNothing) {
  const Vec3 w(0, 10, 0);
  for (int later = 0; later < 2; ++later) {
    Lying scene(later, true);
    scene.jump({0.6, 0, kUnder.z()}, {Vec3::Zero(), w});
    for (int i = 0; i < 12; ++i) {
      scene.house->run(1);
      ASSERT_LT(scene.brick().body.twist().v.norm(), 0.2) << "tick " << i;
      ASSERT_LT((scene.house->servo->cycle().bodies().body(1).body.twist().w - w).norm(), 1e-9) << "tick " << i;
    }
  }
}

/** What a body in a hand once lay on counts for nobody else: a brick beside it fell through what came instead. */
TEST(JumpedObstacle, WhatIsInAHandMakesNothingOfItOld) {
  Lying scene(0, false);
  test::ToolHouse& house = *scene.house;
  house.send(CommandKind::kAddObject, object(kTaken, ShapeKind::kBox, kTileLoad, kOn + Vec3(0.03, 0, 0)));
  scene.setFree(kTaken, 0.01, true);
  house.run(300);
  house.hold(test::attachBox(kTaken, 2 * kTileLoad, house.device.info()));
  scene.replace(kUnder);
  house.run(500);
  const Vec3 up(0, 0, 0.05);
  for (int i = 1; i <= 500; ++i) {
    house.send(CommandKind::kObjectPose,
               poseMessage(kNext, {kUnder + 1e-3 * i * up, Quat::Identity()}, Twist{up, Vec3::Zero()}));
    house.run(1);
  }
  EXPECT_NEAR(scene.brick().body.com().z(), kOn.z() + 0.5 * up.z(), 1e-3);
}

/** The same again, in the same place: nothing is felt of that, to the bit. */
TEST(JumpedObstacle, WhatIsReplacedByItsLikeHoldsOn) {
  for (int later = 0; later < 2; ++later) {
    Lying scene(later, false);
    const Vec3 lay = scene.brick().body.com();
    scene.replace(kUnder);
    for (int i = 0; i < 300; ++i) {
      scene.house->run(1);
      ASSERT_EQ(scene.brick().body.com(), lay) << "tick " << i;
    }
    EXPECT_TRUE(scene.brick().asleep());
  }
}

}  // namespace
}  // namespace hapticd
