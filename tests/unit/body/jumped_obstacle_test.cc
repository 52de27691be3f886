// What a body touches jumps, or is gone and another stands in its slot: until an answer has seen that, contacts with it
// are planes in a frame that is elsewhere.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/stepped/rolling_balls.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::object;

constexpr std::uint32_t kBelow = makeObjectId(40, 1), kNext = makeObjectId(40, 2), kOnTile = makeObjectId(21, 1),
                        kTaken = makeObjectId(22, 1), kWhole = makeObjectId(23, 1);
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
  void put(std::uint32_t id, const Vec3& to, const Twist& V = {}) {
    house->send(CommandKind::kObjectPose, poseMessage(id, {to, Quat::Identity()}, V));
  }
  void jump(const Vec3& to, const Twist& V = {}) { put(kBelow, to, V); }
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

/** Nor what becomes one in the tick in which it jumps. */
TEST(JumpedObstacle, WhatJumpsAndBecomesABodyAtOncePushesNothing) {
  for (int later = 0; later < 2; ++later) {
    Lying scene(later, false);
    const Vec3 to(0.1, 0, 0.4);
    scene.jump(to);
    scene.setFree(kBelow, 1000, false);
    scene.expectFall("became a body");
    EXPECT_LT((scene.house->servo->cycle().bodies().body(1).body.com() - to).norm(), 1e-9);
  }
}

/** Nor a part of one that is put elsewhere, while the whole stays. */
TEST(JumpedObstacle, APartThatIsPutElsewherePushesNothing) {
  for (int later = 0; later < 2; ++later) {
    for (const bool again : {false, true}) {
      Lying scene(later, false);
      test::ToolHouse& house = *scene.house;
      const Vec3 whole(0.1, 0, -0.3), up(0, 0, 0.7);
      house.send(CommandKind::kAddObject, object(kWhole, ShapeKind::kBox, kTileHalf, whole));
      scene.setFree(kWhole, 1000, false);
      house.send(CommandKind::kRemoveObject, ObjectRef{kBelow});
      AddObject part = object(kNext, ShapeKind::kBox, kTileHalf, kUnder - whole);
      part.parent = kWhole;
      house.send(CommandKind::kAddObject, part);
      house.run(200);
      ASSERT_NEAR(scene.brick().body.com().z(), kOn.z(), 1e-5);
      if (again) {
        house.send(CommandKind::kRemoveObject, ObjectRef{kNext});
        part.object = kBelow;
        store(Vec3(up), part.p);
        house.send(CommandKind::kAddObject, part);
      } else {
        scene.put(kNext, up);
      }
      scene.expectFall(again ? "another" : "put elsewhere");
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

/** Of any speed, from any height: as two that have no bounce go on together after a hit. */
TEST(JumpedObstacle, WhatIsPutWithASpeedStillMeetsWhatIsThere) {
  Random random(7);
  for (int i = 0; i < 40; ++i) {
    const bool onto_brick = i % 4 < 2;  // Else onto what is no body, and knows of nothing.
    Lying scene(i % 2, onto_brick);
    test::ToolHouse& house = *scene.house;
    house.send(CommandKind::kSetGravity, SetGravity{});
    const double speed = random.in(0.05, 3), high = random.in(5e-4, 0.01), mass = random.in(0.005, 0.05);
    house.send(CommandKind::kAddObject, object(kTaken, ShapeKind::kBox, kTileLoad, {-0.4, 0.2, 0.3}));
    scene.setFree(kTaken, mass, false);
    house.run(20 + i % 2);
    const FreeBody& put = house.servo->cycle().bodies().body(onto_brick ? 2 : 1);
    const auto top = [&] { return onto_brick ? scene.brick().body.com().z() + kTileLoad.z() : 0; };
    const auto far = [&] { return put.body.com().z() - kTileLoad.z() - top(); };
    const Vec3 to = onto_brick ? Vec3(kOn + Vec3(0, 0, 2 * kTileLoad.z())) : Vec3(kUnder + Vec3(-0.03, 0, 0.015));
    scene.put(kTaken, to + Vec3(0, 0, high), {Vec3(0, 0, -speed), Vec3::Zero()});
    const int ticks = static_cast<int>(1000 * high / speed) + 12;
    double nearest = high;
    for (int tick = 0; tick < ticks; ++tick) {
      house.run(1);
      nearest = std::min(nearest, far());
    }
    // A question and an answer later it has gone so far at most.
    EXPECT_GT(nearest, std::min(0.0, high - 3e-3 * speed) - 1e-5) << i << ": " << speed << " m/s, " << high;
    EXPECT_GT(far(), -kTileLoad.z()) << i;
    const double apart = put.body.twist().v.z() - (onto_brick ? scene.brick().body.twist().v.z() : 0);
    EXPECT_LT(apart, 0.2) << i;
    EXPECT_GT(apart, -1e-6) << i;
  }
}

/** What comes up at a speed below a brick, from far off, lifts it as if it had always come. */
TEST(JumpedObstacle, WhatJumpsAndMovesLiftsWhatItMeets) {
  Random random(8);
  for (int i = 0; i < 40; ++i) {
    const bool becomes = i % 4 >= 2;
    Lying scene(i % 2, false);
    test::ToolHouse& house = *scene.house;
    const double speed = random.in(0.2, 1), below = random.in(0.001, 0.01);
    scene.jump({-0.6, 0.2, -0.4});
    house.send(CommandKind::kSetGravity, SetGravity{});
    scene.put(kOnTile, {-0.3, 0, 0.2});
    house.run(30);
    const Vec3 under = scene.brick().body.com() - Vec3(0, 0, kTileLoad.z() + kTileHalf.z() + below);
    if (becomes) scene.setFree(kBelow, 1000, false);
    scene.jump(under, {Vec3(0, 0, speed), Vec3::Zero()});
    house.run(static_cast<int>(1000 * below / speed) + 20);
    const SceneObject& slab = house.servo->cycle().scene().slot(objectSlot(kBelow));
    EXPECT_NEAR(scene.brick().body.twist().v.z(), speed, 0.15) << i << ": " << speed << " m/s, " << below;
    EXPECT_GT(scene.brick().body.com().z() - slab.X_WO.p.z(), kTileLoad.z() + kTileHalf.z() - 1e-3) << i;
  }
}

/** What does not jump is as if nothing had, to the bit. */
TEST(JumpedObstacle, WhatLiesElsewhereFeelsNothing) {
  const auto lie = [](bool jumps) {
    Lying scene(0, true);
    scene.house->send(CommandKind::kAddObject, object(kTaken, ShapeKind::kBox, kTileLoad, {-0.4, 0.2, 0.3}));
    scene.setFree(kTaken, 0.01, false);
    std::vector<Vec3> places;
    for (int i = 0; i < 100; ++i) {
      if (jumps && i % 7 == 3) scene.put(kTaken, {-0.4 - 0.03 * (i % 3), 0.2, 0.3}, {Vec3(1, 0, 0), Vec3(0, 5, 0)});
      scene.house->run(1);
      places.push_back(scene.brick().body.com());
      places.push_back(scene.brick().body.twist().w);
    }
    return places;
  };
  EXPECT_EQ(lie(false), lie(true));
}

/** A servo that stood still for long has no answer from where a wall now is, whatever its clock says. */
TEST(JumpedObstacle, TheHandIsNotHitAfterMissedPeriodsEither) {
  for (int later = 0; later < 2; ++later) {
    const auto house = test::houseWithoutFloor();
    house->send(CommandKind::kAddObject, object(kBelow, ShapeKind::kBox, kTileHalf, {0, 0, -0.01}));
    house->aim({0, 0, 0.0045});
    house->hold();
    house->run(300 + later);
    const double pressed = house->out().command.force.norm();
    ASSERT_GT(pressed, 0.1);
    house->send(CommandKind::kObjectPose,
                poseMessage(kBelow, {{0.5, 0, -0.01}, Quat::Identity()}, {Vec3::Zero(), Vec3(0, 10, 0)}));
    house->run(1, false);
    house->clock.advance(20 * test::kPeriodNs);
    for (int i = 0; i < 20; ++i) {
      house->run(1, i > 2);
      EXPECT_LT(house->out().command.force.norm(), pressed + 0.5) << "tick " << i;
    }
  }
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

/** Not even where the hand is so near that a pose of a client's would tell a motion. */
TEST(JumpedObstacle, WhatIsTakenUpPushesNothingAsItComesIntoTheHand) {
  test::ToolHouse house;
  house.send(CommandKind::kObjectPose, hd_object_pose{test::kTool, 0, {0.1, 0, 0.04}, {1}, {}, {}});
  test::addBall(house, test::kRolled, {0.1 - 0.01 - test::kBallRadius, 0, 0.04}, 0.3);
  house.run(200);
  const RigidBody& ball = house.servo->cycle().bodies().body(0).body;
  const Vec3 lies = ball.com();
  house.send(CommandKind::kAttachTool, house.tool());
  for (int i = 0; i < 100; ++i) {
    house.run(1);
    ASSERT_LT(ball.twist().v.norm(), 1e-3) << i;
  }
  EXPECT_LT((house.place().p - Vec3(0, 0, 0.04)).norm(), 1e-3) << "it is in the hand";
  EXPECT_LT((ball.com() - lies).norm(), 1e-4);
}

}  // namespace
}  // namespace hapticd
