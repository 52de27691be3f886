// Objects that move freely, through the whole cycle: they fall, lie, sleep and wake.
#include <gtest/gtest.h>

#include <cmath>

#include "rt/cycle/free_bodies.h"
#include "tests/support/stepped/rolling_balls.h"

namespace hapticd {
namespace {

using test::addBall;
using test::body;
using test::gravity;
using test::kBallRadius;
using test::kFloor;
using test::kOther;
using test::kRolled;
using test::object;
using test::seen;
using House = test::ToolHouse;

TEST(FreeBodies, OneThatFallsLiesStillOnTheFloor) {
  House house;
  addBall(house, kRolled, {0.1, 0, 0.05}, 0.2);
  gravity(house, 9.81);
  house.run(50);
  const double t = 0.049;  // the contacts' first answer is in the first tick or two
  EXPECT_NEAR(seen(house, kRolled).X_WO.p.z(), 0.05 - 0.5 * 9.81 * t * t, 1.5e-3) << "free fall";
  house.run(1500);
  const Vec3 lies = seen(house, kRolled).X_WO.p;
  EXPECT_NEAR(lies.z(), kBallRadius, 2e-5);
  EXPECT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  house.run(3000);
  EXPECT_EQ(seen(house, kRolled).X_WO.p, lies) << "at rest it stays, to the bit";
  EXPECT_TRUE(seen(house, kRolled).V_WO.v.isZero(0));
  // What it lies on goes: it falls on.
  house.send(CommandKind::kObjectFlags, hd_object_flags{kFloor, HD_OBJECT_ENABLED, 0, 0});
  house.run(100);
  EXPECT_LT(seen(house, kRolled).X_WO.p.z(), 0);
}

/** As a tool does: what has no stiffness is not there for either. */
TEST(FreeBodies, ObjectsWithoutStiffnessAreNotTouched) {
  const hd_material none{0, 0, 0.4, 0.3}, some{1000, 0, 0.4, 0.3};
  const auto material = [](House& house, std::uint32_t id, const hd_material& m) {
    house.send(CommandKind::kObjectMaterial, hd_object_material{id, 0, m});
  };
  House house;
  addBall(house, kRolled, {0.1, 0, kBallRadius + 1e-3}, 0.2);
  gravity(house, 9.81);
  house.run(1000);
  ASSERT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  material(house, kFloor, none);
  house.run(50, false);
  EXPECT_LT(seen(house, kRolled).X_WO.p.z(), kBallRadius - 5e-3) << "at once, whatever the last answer said";
  house.run(100);
  EXPECT_LT(seen(house, kRolled).X_WO.p.z(), -0.02) << "what it lay on is gone, and it has passed";

  // Of two bodies neither touches the other if one has none.
  for (const bool other : {false, true}) {
    House pair;
    addBall(pair, kRolled, {0.1, 0, 0.1}, 0.2);
    addBall(pair, kOther, {0.16, 0, 0.1}, 0.2);
    material(pair, other ? kOther : kRolled, none);
    pair.send(CommandKind::kObjectPose, hd_object_pose{kRolled, 0, {0.1, 0, 0.1}, {1}, {0.5}, {}});
    pair.run(200);
    EXPECT_NEAR(seen(pair, kRolled).X_WO.p.x(), 0.2, 3e-3) << other;
    EXPECT_EQ(seen(pair, kOther).X_WO.p.x(), 0.16) << other;
    material(pair, other ? kOther : kRolled, some);
    pair.send(CommandKind::kObjectPose, hd_object_pose{kRolled, 0, {0.1, 0, 0.1}, {1}, {0.5}, {}});
    pair.run(200);
    EXPECT_LT(seen(pair, kRolled).X_WO.p.x(), 0.165) << other;
    EXPECT_GT(seen(pair, kOther).X_WO.p.x(), 0.19) << other;
  }
}

/** Eight boxes have more touches than one step takes: none may go without, as the last once did, and fell through. */
TEST(FreeBodies, AsManyAsThereCanBeAllLieOnTheFloor) {
  const Vec3 half(0.03, 0.03, 0.02);
  House house;
  for (std::uint32_t k = 0; k < kMaxBodies; ++k) {
    const std::uint32_t id = makeObjectId(10 + k, 1);
    house.send(CommandKind::kAddObject, object(id, ShapeKind::kBox, half, {0.1 * k - 0.35, 0.2, half.z()}));
    SetBody order = body(id, 0.2);
    const Mat3 inertia = MassProperties::ofBox(order.mass, 2 * half).inertia_O;
    for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
    house.send(CommandKind::kSetBody, order);
  }
  house.run(20);
  gravity(house, 9.81);
  double sunk = 0;
  for (int i = 0; i < 600; ++i) {
    house.run(1);
    for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
      sunk = std::max(sunk, half.z() - house.servo->cycle().bodies().body(k).body.com().z());
    }
  }
  EXPECT_LT(sunk, 1.1 * Tool::kSlop);
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) EXPECT_TRUE(house.servo->cycle().bodies().body(k).asleep()) << int{k};
}

/** A floor that moves slower than what falls asleep once rose through what slept on it. */
TEST(FreeBodies, WhatLiesOnASlowFloorGoesWithIt) {
  const double slow = 0.5 * FreeBody::kRestSpeed;
  for (const Vec3& way : {Vec3(0, 0, slow), Vec3(slow, 0, 0)}) {
    House house;
    addBall(house, kRolled, {0.1, 0, kBallRadius}, 0.2);
    SetShape shape{kRolled, 0, {static_cast<std::uint32_t>(ShapeKind::kBox), 0, {}}};
    store(Vec3::Constant(kBallRadius), shape.shape.size);
    house.send(CommandKind::kSetShape, shape);
    gravity(house, 9.81);
    house.run(500);
    ASSERT_TRUE(house.servo->cycle().bodies().body(0).asleep());
    hd_object_pose moves{kFloor, 0, {}, {1}, {}, {}};
    store(way, moves.v);
    house.send(CommandKind::kObjectPose, moves);
    house.run(4000);
    const Vec3 gone = seen(house, kFloor).X_WO.p;
    EXPECT_GT(gone.norm(), 1.9e-3);
    EXPECT_LT((seen(house, kRolled).X_WO.p - Vec3(0.1, 0, kBallRadius) - gone).norm(), 2e-5);
  }
}

/** What friction holds on a slope sleeps, and slides when there is none any more. */
TEST(FreeBodies, OneThatNothingHoldsAnyMoreWakes) {
  const Quat steep = fromRotationVector({0, 0.3, 0});
  House house;
  AddObject slope = object(kOther, ShapeKind::kBox, {0.5, 0.1, 0.01}, {0, 0.5, 0.3});
  store(steep, slope.q);
  house.send(CommandKind::kAddObject, slope);
  AddObject box =
      object(kRolled, ShapeKind::kBox, Vec3::Constant(kBallRadius), Vec3(0, 0.5, 0.3) + steep * Vec3(0, 0, 0.03));
  store(steep, box.q);
  house.send(CommandKind::kAddObject, box);
  house.send(CommandKind::kSetBody, body(kRolled, 0.2));
  house.run(20);
  gravity(house, 9.81);
  house.run(1000);
  ASSERT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  const Vec3 from = seen(house, kRolled).X_WO.p;
  house.send(CommandKind::kObjectMaterial, hd_object_material{kOther, 0, {1000, 0, 0, 0}});
  house.run(300);
  EXPECT_NEAR((seen(house, kRolled).X_WO.p - from).norm(), 0.5 * 9.81 * std::sin(0.3) * 0.3 * 0.3, 2e-3);
}

TEST(FreeBodies, OneThatCreepsFallsAsleepAndStays) {
  House house;
  addBall(house, kRolled, {0.1, 0, 0.1}, 0.2);
  hd_object_pose pose{kRolled, 0, {0.1, 0, 0.1}, {1}, {0.5 * FreeBody::kRestSpeed}, {}};
  house.send(CommandKind::kObjectPose, pose);
  house.run(200);
  EXPECT_GT(seen(house, kRolled).X_WO.p.x(), 0.10008) << "it has crept on for a while";
  house.run(200);
  ASSERT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  const Vec3 lies = seen(house, kRolled).X_WO.p;
  house.run(500);
  EXPECT_EQ(seen(house, kRolled).X_WO.p, lies);
}

TEST(FreeBodies, OneFallsOnAnotherThatSleepsAndBothComeToRest) {
  House house;
  gravity(house, 9.81);
  addBall(house, kOther, {0.1, 0, 0.021}, 0.2, 1);
  house.run(1000);
  ASSERT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  addBall(house, kRolled, {0.105, 0, 0.1}, 0.2, 1);
  house.run(300);
  EXPECT_LT(seen(house, kOther).X_WO.p.x(), 0.0999) << "woken, and pushed aside";
  house.run(6000);
  const double apart = (seen(house, kRolled).X_WO.p - seen(house, kOther).X_WO.p).norm();
  EXPECT_GT(apart, 2 * kBallRadius - 5e-5);
  for (const std::uint32_t id : {kRolled, kOther}) EXPECT_GT(seen(house, id).X_WO.p.z(), kBallRadius - 5e-5);
}

/** Each of a pile has contacts with those above and below: none may keep the others awake that is at rest itself. */
TEST(FreeBodies, APileFallsAsleepAndStays) {
  for (const int many : {2, 3, 4}) {
    for (const double size : {0.1, 1.0}) {
      House house;
      gravity(house, 9.81);
      const Vec3 half = size * Vec3(0.03, 0.03, 0.02);
      std::vector<std::uint32_t> pile;
      for (int k = 0; k < many; ++k) {
        const std::uint32_t id = makeObjectId(10 + static_cast<std::uint32_t>(k), 1);
        AddObject brick = object(id, ShapeKind::kBox, half, {0.3 + 1e-3 * size * k, 0, (2 * k + 1) * half.z()});
        store(fromRotationVector({0, 0, 0.2 * k}), brick.q);
        house.send(CommandKind::kAddObject, brick);
        SetBody order = body(id, 0.2 * size * size * size);
        const Mat3 inertia = MassProperties::ofBox(order.mass, 2 * half).inertia_O;
        for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
        house.send(CommandKind::kSetBody, order);
        pile.push_back(id);
      }
      house.run(1500);
      std::vector<Vec3> lies;
      for (int k = 0; k < many; ++k) {
        EXPECT_TRUE(house.servo->cycle().bodies().body(static_cast<std::uint8_t>(k)).asleep()) << many << " " << size;
        lies.push_back(seen(house, pile[static_cast<std::size_t>(k)]).X_WO.p);
      }
      house.run(500);
      for (std::size_t k = 0; k < lies.size(); ++k) EXPECT_EQ(seen(house, pile[k]).X_WO.p, lies[k]) << k;
      // What the lowest is pushed by wakes all that lie on it.
      house.send(CommandKind::kObjectPose, hd_object_pose{pile[0], 0, {lies[0].x(), 0, lies[0].z()}, {1}, {0.1F}, {}});
      house.run(20);
      for (std::size_t k = 0; k < lies.size(); ++k) EXPECT_NE(seen(house, pile[k]).X_WO.p, lies[k]) << k;
    }
  }
}

/** What lies on it holds no brick up, nor does what stands beside it. */
TEST(FreeBodies, APileFallsWhenItsFloorGoes) {
  for (const bool beside : {false, true}) {
    House house;
    gravity(house, 9.81);
    const Vec3 half(0.03, 0.03, 0.02);
    std::vector<std::uint32_t> pile;
    for (int k = 0; k < 2; ++k) {
      const std::uint32_t id = makeObjectId(10 + static_cast<std::uint32_t>(k), 1);
      const Vec3 at = beside ? Vec3(0.3 + 0.0602 * k, 0, half.z()) : Vec3(0.3, 0, (2 * k + 1) * half.z());
      house.send(CommandKind::kAddObject, object(id, ShapeKind::kBox, half, at));
      SetBody order = body(id, 0.2);
      const Mat3 inertia = MassProperties::ofBox(order.mass, 2 * half).inertia_O;
      for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
      house.send(CommandKind::kSetBody, order);
      pile.push_back(id);
    }
    house.run(1500);
    for (std::uint8_t k = 0; k < 2; ++k) ASSERT_TRUE(house.servo->cycle().bodies().body(k).asleep()) << beside;
    house.send(CommandKind::kObjectFlags, hd_object_flags{kFloor, HD_OBJECT_ENABLED, 0, 0});
    house.run(100);
    for (const std::uint32_t id : pile) EXPECT_LT(seen(house, id).X_WO.p.z(), half.z()) << beside << " " << id;
  }
}

/** A body that gets another shape flies on: its origin as fast as before. */
TEST(FreeBodies, OneThatGetsAnotherCentreOfMassMovesOnAsItDid) {
  House house;
  addBall(house, kRolled, {0.1, 0, 0.3}, 0.2);
  house.send(CommandKind::kObjectPose, hd_object_pose{kRolled, 0, {0.1, 0, 0.3}, {1}, {0.1F, 0, 0}, {0, 0, 5}});
  house.run(2);
  const auto velocity = [&] { return seen(house, kRolled).V_WO.v; };
  const Vec3 before = velocity();
  ASSERT_NEAR(before.x(), 0.1, 2e-3);
  SetBody order = body(kRolled, 0.2);
  order.com[1] = 0.01;
  house.send(CommandKind::kSetBody, order);
  house.run(3);
  EXPECT_LT((velocity() - before).norm(), 5e-3) << "5 rad/s about a point 1 cm off are 5 cm/s";
}

/** Before the order comes that it is none: else it would go on for ever, as what a client has given a velocity. */
TEST(FreeBodies, OneThatGetsAShapeThatCannotMoveStands) {
  House house;
  addBall(house, kRolled, {0.1, 0, 0.3}, 0.2);
  house.send(CommandKind::kObjectPose, hd_object_pose{kRolled, 0, {0.1, 0, 0.3}, {1}, {0.1F, 0, 0}, {}});
  house.run(2);
  house.send(CommandKind::kSetShape, SetShape{kRolled, 0, {static_cast<std::uint32_t>(ShapeKind::kPlane), 0, {}}});
  house.run(1);
  house.send(CommandKind::kSetBody, SetBody{.object = kRolled});
  house.run(2);
  const Vec3 before = seen(house, kRolled).X_WO.p;
  house.run(100);
  EXPECT_EQ(seen(house, kRolled).X_WO.p, before);
  EXPECT_TRUE(seen(house, kRolled).V_WO.v.isZero(0));
}

}  // namespace
}  // namespace hapticd
