/** @file
 * Contact with moving objects, and what the hand may do at the border of contact.
 */
#include <gtest/gtest.h>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;

const Quat kNoTurn = Quat::Identity();

TEST(ProxyInMotion, PlateRaisedByPosesPushesLikeOneRaisedByVelocity) {
  for (const double speed : {0.01, 1.0, 5.0}) {
    TestMesh mesh = test::boxMesh(Vec3(0.2, 0.2, 0.000025));
    TestScene t;
    const auto id = t.addMesh(mesh.view(), {Vec3(0, 0, -0.01), kNoTurn});
    t.tick(Vec3::Zero());
    for (int i = 1; - 0.01 + speed * kTick * i < 0.02; ++i) {
      const double z = -0.01 + speed * kTick * i;
      t.pose(id, {Vec3(0, 0, z), kNoTurn});
      const double top = z + double{0.000025f};
      ASSERT_NEAR(t.tick(Vec3::Zero()).force.z(), 1000 * std::max(top, 0.0), 1e-8) << speed << " " << i;
    }
  }
}

/** From tick to tick it stands before the hand and behind it, and never where the hand is. */
TEST(ProxyInMotion, ABallThatFliesPastTheHandWithinATickIsFelt) {
  for (const double radius : {0.0, 0.001}) {
    TestScene t(radius);
    const auto id = t.add(ShapeKind::kSphere, Vec3(0.0005, 0, 0), {Vec3(-0.0025, 0, 0), kNoTurn});
    t.tick(Vec3::Zero());
    t.pose(id, {Vec3(0.0025, 0, 0), kNoTurn}, {Vec3(5, 0, 0), Vec3::Zero()});
    EXPECT_NEAR(t.tick(Vec3::Zero()).force.x(), 1000 * (0.0025 + 0.0005 + radius), 1e-9) << radius;
  }
}

TEST(ProxyInMotion, DraggedPlanePullsByDynamicFriction) {
  for (const double depth : {1e-5, 1e-3}) {
    TestScene t;
    const auto id = t.add(ShapeKind::kBox, Vec3(1, 1, 0.01), {Vec3(0, 0, -0.01), kNoTurn}, {1000, 0, 0.5, 0.3});
    t.tick(Vec3(0, 0, 0.001));
    t.tick(Vec3(0, 0, -depth));
    t.pose(id, {Vec3(0, 0, -0.01), kNoTurn}, {Vec3(0.05, 0.02, 0), Vec3::Zero()});
    SurfaceContact c;
    for (int i = 0; i < 200; ++i) c = t.tick(Vec3(0, 0, -depth));
    EXPECT_NEAR(c.force.z(), 1000 * depth, 1e-9);
    const Vec3 along = Vec3(0.05, 0.02, 0).normalized();
    EXPECT_LT((c.force - 1000 * depth * (Vec3::UnitZ() + 0.3 * along)).norm(), 1e-9);
    EXPECT_TRUE(c.slip);
  }
}

TEST(ProxyInMotion, StuckProxyRidesAlongExactly) {
  TestScene t;
  const auto id = t.add(ShapeKind::kBox, Vec3(1, 1, 0.01), {Vec3(0, 0, -0.01), kNoTurn}, {1000, 0, 0.5, 0.3});
  t.tick(Vec3(0, 0, 0.001));
  t.tick(Vec3(0, 0, -0.005));
  for (int i = 1; i <= 100; ++i) {
    const double x = 1e-5 * i;
    t.pose(id, {Vec3(x, 0, -0.01), kNoTurn});
    const SurfaceContact& c = t.tick(Vec3(0, 0, -0.005));
    ASSERT_NEAR(c.force.x(), 1000 * x, 1e-9);
    ASSERT_FALSE(c.slip);
  }
}

TEST(ProxyInMotion, RotatingBoxNeverTakesTheProxyIn) {
  for (const double rate : {1.0, 10.0, 60.0}) {
    for (const bool as_mesh : {false, true}) {
      const Vec3 half(0.05, 0.03, 0.02);
      TestMesh mesh = test::boxMesh(half);
      TestScene t;
      const auto id = as_mesh ? t.addMesh(mesh.view()) : t.add(ShapeKind::kBox, half);
      const Vec3 hip(0.033, 0.015, 0.001);
      t.tick(Vec3(0.2, 0, 0));
      t.tick(Vec3(0.2, 0.2, 0));
      t.pose(id, {}, {Vec3::Zero(), rate * Vec3(0.1, 0.2, 1).normalized()});
      double most = 0;
      for (int i = 0; i < 2000; ++i) {
        const Vec3 p = i < 100 ? Vec3(hip + (1 - i / 100.0) * Vec3(0.1, 0.1, 0)) : hip;
        const SurfaceContact& c = t.tick(p);
        const SceneObject& box = *t.scene->find(id);
        const Vec3 x = box.X_WO.inverse() * c.proxy;
        ASSERT_GE((x.cwiseAbs() - half).maxCoeff(), -1e-8) << rate << " " << i;
        ASSERT_LT((c.force - 1000 * (c.proxy - p)).norm(), 1e-9);
        most = std::max(most, c.force.norm());
      }
      EXPECT_GT(most, 1);
    }
  }
}

TEST(ProxyInMotion, ParentsCarryTheirChildrenAndTheProxy) {
  TestScene t;
  const auto arm = t.add(ShapeKind::kGroup, Vec3::Zero());
  t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.001), {Vec3(0, 0, -0.05), kNoTurn}, {1000, 0, 0, 0}, HD_OBJECT_ENABLED, arm);
  t.tick(Vec3::Zero());
  t.pose(arm, {}, {Vec3(0, 0, 1), Vec3::Zero()});
  for (int i = 0; i < 80; ++i) {
    const double top = -0.049 + kTick * i;
    ASSERT_NEAR(t.tick(Vec3::Zero()).force.z(), 1000 * std::max(0.0, top), 1e-9);
  }
}

TEST(ProxyInMotion, TeleportOverTheHandIsNotAPush) {
  TestScene t;
  const auto id = t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.1), {Vec3(0, 0, -1), kNoTurn});
  for (int i = 0; i < 30; ++i) t.tick(Vec3::Zero());
  t.pose(id, {Vec3(0, 0, 0.01), kNoTurn});
  EXPECT_EQ(t.tick(Vec3::Zero()).force, Vec3(Vec3::Zero()));
  EXPECT_EQ(t.scene->find(id)->V_WO.v, Vec3(Vec3::Zero()));
  t.tick(Vec3(0, 0, 0.2));
  EXPECT_NEAR(t.tick(Vec3(0, 0, 0.1)).force.z(), 10, 1e-9) << "felt again once it has left";
}

TEST(ProxyInMotion, SqueezedBetweenTwoPlatesItComesOutOnItsOwnSideOfBoth) {
  TestScene t;
  const auto low = t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.005), {Vec3(0, 0, -0.01), kNoTurn});
  t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.005), {Vec3(0, 0, 0.01), kNoTurn});
  t.tick(Vec3::Zero());
  for (int i = 1; i <= 24; ++i) {  // Up until the plates overlap by 2 mm, and down again.
    const double z = -0.01 + 1e-3 * (i <= 12 ? i : 24 - i);
    t.pose(low, {Vec3(0, 0, z), kNoTurn});
    const SurfaceContact& c = t.tick(Vec3::Zero());
    ASSERT_TRUE(isFinite(c.force));
    ASSERT_LE(c.force.norm(), 13);
  }
  const SurfaceContact& c = t.tick(Vec3::Zero());
  EXPECT_EQ(c.force, Vec3(Vec3::Zero()));
  EXPECT_NEAR(t.tick(Vec3(0, 0, 0.006)).force.z(), -1, 1e-9) << "the upper plate still holds from below";
  EXPECT_NEAR(t.tick(Vec3(0, 0, -0.007)).force.z(), 2, 1e-9) << "and the lower one from above";
}

TEST(ProxyInMotion, SqueezedItDoesNotSlipOutThroughAPlate) {
  for (const double away : {-0.03, 0.03}) {  // Where the hand goes while the plates overlap: beyond either.
    TestScene t;
    const auto low = t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.005), {Vec3(0, 0, -0.01), kNoTurn});
    t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.005), {Vec3(0, 0, 0.01), kNoTurn});
    t.tick(Vec3::Zero());
    for (int i = 1; i <= 24; ++i) {
      t.pose(low, {Vec3(0, 0, -0.01 + 1e-3 * (i <= 12 ? i : 24 - i)), kNoTurn});
      t.tick(Vec3(0, 0, i < 12 ? 0 : away));
    }
    EXPECT_NEAR(t.tick(Vec3(0, 0, away)).force.z(), away < 0 ? 25 : -25, 1e-8);
  }
}

TEST(ProxyInMotion, WhatLandsOnASqueezedHandIsNotFelt) {
  for (const bool hidden : {false, true}) {
    TestScene t;
    const auto low = t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.005), {Vec3(0, 0, -0.01), kNoTurn});
    t.add(ShapeKind::kBox, Vec3(0.1, 0.1, 0.005), {Vec3(0, 0, 0.01), kNoTurn});
    const auto ball = t.add(ShapeKind::kSphere, Vec3(0.03, 0, 0), {Vec3(0.3, 0, 0), kNoTurn});
    t.tick(Vec3::Zero());
    for (int i = 1; i <= 24; ++i) {
      t.pose(low, {Vec3(0, 0, -0.01 + 1e-3 * (i <= 12 ? i : 24 - i)), kNoTurn});
      if (i == 12) t.pose(ball, {Vec3::Zero(), kNoTurn});  // A teleport, or seen again where it was not before.
      if (hidden) t.flags(ball, HD_OBJECT_ENABLED, i < 11 || i > 13 ? 0u + HD_OBJECT_ENABLED : 0u);
      ASSERT_NE(t.tick(Vec3::Zero()).object, ball) << i;
    }
    EXPECT_EQ(t.tick(Vec3::Zero()).force, Vec3(Vec3::Zero()));
  }
}

TEST(ProxyInMotion, FirstContactIsFeltInItsOwnTickAndLeavingNeverPulls) {
  TestScene t;
  t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {2000, 5, 0.3, 0.2});
  bool inside = false;
  int touches = 0;
  for (int i = 0; i < 4000; ++i) {
    const double z = 0.002 * std::cos(0.01 * i) - 0.0005, vz = -0.02 * std::sin(0.01 * i);
    const SurfaceContact& c = t.tick(Vec3(0.001 * i * kTick, 0, z), Vec3(0.001, 0, vz));
    if (z >= 0) {
      ASSERT_EQ(c.force, Vec3(Vec3::Zero())) << i;
    } else {
      ASSERT_NEAR(c.force.z(), std::max(0.0, -2000 * z - 5 * vz), 1e-9) << i;
    }
    ASSERT_GE(c.force.z(), 0);
    ASSERT_EQ(c.touch, z < 0 && !inside);
    ASSERT_EQ(c.object != 0, z < 0);
    inside = z < 0;
    touches += c.touch;
  }
  EXPECT_EQ(touches, 7);
}

TEST(ProxyInMotion, NotAHairAboveThePlaneIsFelt) {
  TestScene t;
  t.add(ShapeKind::kPlane, Vec3::Zero());
  t.tick(Vec3(0, 0, 0.1));
  t.tick(Vec3(0, 0, -0.1));
  for (const double z : {1e-15, 1e-18, 0.0}) EXPECT_EQ(t.tick(Vec3(0, 0, z)).force, Vec3(Vec3::Zero())) << z;
  EXPECT_NEAR(t.tick(Vec3(0, 0, -1e-12)).force.z() / 1e-9, 1, 1e-6);
}

TEST(ProxyInMotion, DampingActsOnTheVelocityRelativeToTheSurface) {
  TestScene t;
  const auto id = t.add(ShapeKind::kBox, Vec3(1, 1, 0.1), {Vec3(0, 0, -0.1), kNoTurn}, {1000, 10, 0, 0});
  t.tick(Vec3(0, 0, 0.01));
  t.tick(Vec3(0, 0, -0.001));
  t.pose(id, {Vec3(0, 0, -0.1), kNoTurn}, {Vec3(0.3, 0, 0.05), Vec3::Zero()});
  t.tick(Vec3(0, 0, -0.001));  // The tick of the pose command: it stands where it was put.
  const SurfaceContact& c = t.tick(Vec3(0, 0, -0.001), Vec3(0, 0, 0.02));
  EXPECT_LT((c.force - Vec3(0, 0, 1000 * (0.001 + 5e-5) + 10 * 0.03)).norm(), 1e-9);
}

/** A plate that comes at 60 poses a second is damped as one that comes at a speed, at no time as a step in its tick. */
TEST(ProxyInMotion, DampingOfAPlateMovedByPosesIsThatOfItsMotion) {
  constexpr double kDamping = 20, kSpeed = 0.1;
  TestScene t;
  const auto id = t.add(ShapeKind::kPlane, Vec3::Zero(), {Vec3(0, 0, -0.02), kNoTurn}, {1000, kDamping, 0, 0});
  t.tick(Vec3::Zero());
  int felt = 0;
  for (int i = 0; i < 400; ++i) {
    const double z = -0.02 + kSpeed * kTick * i;
    if (i % 17 == 0) t.pose(id, {Vec3(0, 0, z), kNoTurn});
    const SurfaceContact& c = t.tick(Vec3::Zero());
    if (c.object == 0) continue;
    ++felt;
    ASSERT_NEAR(c.damping, kDamping * kSpeed, 1e-9) << i;
    ASSERT_NEAR(c.force.z(), 1000 * c.depth + kDamping * kSpeed, 1e-6) << i;
  }
  EXPECT_GT(felt, 150);
}

TEST(ProxyInMotion, RemovedAndDisabledObjectsLetGo) {
  TestScene t;
  const auto a = t.add(ShapeKind::kPlane, Vec3::Zero());
  t.tick(Vec3(0, 0, 0.1));
  EXPECT_TRUE(t.tick(Vec3(0, 0, -0.1)).touch);
  t.flags(a, HD_OBJECT_ENABLED, 0);
  EXPECT_EQ(t.tick(Vec3(0, 0, -0.1)).object, 0u);
  t.flags(a, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED);
  EXPECT_EQ(t.tick(Vec3(0, 0, -0.1)).object, 0u) << "enabled about the hand: nothing until it has left";
  t.tick(Vec3(0, 0, 0.1));
  EXPECT_EQ(t.tick(Vec3(0, 0, -0.1)).object, a);
  EXPECT_EQ(t.remove(a), ErrorCode::kOk);
  EXPECT_EQ(t.tick(Vec3(0, 0, -0.1)).object, 0u);
}

}  // namespace
}  // namespace hapticd
