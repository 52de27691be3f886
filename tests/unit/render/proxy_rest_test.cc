/** @file
 * A proxy that rests on a face is held by it without a sweep; not by one that has gone.
 */
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

/** Two boxes, their tops at 0 and at -0.5 mm; the first lies under the hand. */
struct Rest {
  TestMesh high = test::boxMesh(Vec3(0.05, 0.05, 0.01), Vec3(0, 0, -0.01));
  TestMesh low = test::boxMesh(Vec3(0.05, 0.05, 0.01), Vec3(0, 0, -0.0105));
  TestScene t;
  std::uint32_t id = 0, other = 0;
  Vec3 hip = Vec3(0.012, 0.003, -0.001);

  explicit Rest(double radius) {
    t.proxy.setRadius(radius);
    hip.z() += radius;
    other = t.addMesh(low.view(), {Vec3(1, 0, 0), Quat::Identity()});
    id = t.addMesh(high.view());
    t.tick(hip + Vec3(0, 0, 0.01));
    for (int i = 0; i < 3; ++i) t.tick(hip);
  }
  /** With the hand where it is. */
  double force() { return t.tick(hip).force.z(); }
};

TEST(ProxyAtRest, NeedsLessThanToComeToRest) {
  for (const double radius : {0.0, 0.002}) {
    Rest r(radius);
    EXPECT_NEAR(r.force(), 1, 1e-9);
    const std::uint32_t at_rest = r.t.contact.work;
    r.t.proxy.reset(r.hip + Vec3(0, 0, 0.01));
    r.t.tick(r.hip);
    EXPECT_LT(at_rest, r.t.contact.work);
  }
}

TEST(ProxyAtRest, IsNotHeldByAFaceThatHasGone) {
  for (const double radius : {0.0, 0.002}) {
    Rest disabled(radius), removed(radius), gone(radius), swapped(radius);
    ASSERT_NEAR(disabled.force(), 1, 1e-9);
    disabled.t.flags(disabled.id, HD_OBJECT_ENABLED, 0);
    EXPECT_EQ(disabled.force(), 0);
    ASSERT_EQ(removed.t.remove(removed.id), ErrorCode::kOk);
    EXPECT_EQ(removed.force(), 0);
    gone.t.pose(gone.id, {Vec3(0, 0, -0.5), Quat::Identity()});
    EXPECT_EQ(gone.force(), 0);
    const ShapeParameters lower_box{static_cast<std::uint32_t>(ShapeKind::kMesh), 1, {}};
    ASSERT_EQ(swapped.t.setShape(swapped.id, lower_box), ErrorCode::kOk);
    EXPECT_NEAR(swapped.force(), 0.5, 1e-6);
  }
}

/** Of what has moved in a tick without a reading, as the servo begins anew after one. */
TEST(ProxyAtRest, IsNotHeldByWhereAFaceWasBeforeAReadingWasLost) {
  for (const double radius : {0.0, 0.002}) {
    Rest r(radius);
    ASSERT_NEAR(r.force(), 1, 1e-9);
    r.t.pose(r.id, {Vec3(0, 0, 0.0005), Quat::Identity()});
    EXPECT_EQ(r.t.tick(Vec3(NAN, 0, 0)).force, Vec3::Zero());
    EXPECT_EQ(r.force(), 0) << "about it: felt when it has been left";
    r.t.tick(r.hip + Vec3(0, 0, 0.01));
    EXPECT_NEAR(r.force(), 1.5, 1e-6);
  }
}

/** What jumps to a place as far from the origin has the same hair, and the hand is still a hair above where it was. */
TEST(ProxyAtRest, IsNotHeldByAFaceThatHasJumpedAsFarFromTheOrigin) {
  for (const double radius : {0.0, 0.002}) {
    for (const ShapeKind kind : {ShapeKind::kBox, ShapeKind::kMesh}) {
      TestMesh box = test::boxMesh(Vec3(0.05, 0.05, 0.01));
      TestScene t(radius);
      const Vec3 at(0.5, 0, -0.01), hip(0.512, 0.003, radius - 0.001);
      MeshView* const view = kind == ShapeKind::kMesh ? box.view() : nullptr;
      const std::uint32_t id =
          t.add(kind, Vec3(0.05, 0.05, 0.01), {at, Quat::Identity()}, {1000, 0, 0, 0}, HD_OBJECT_ENABLED, 0, view);
      t.tick(hip + Vec3(0, 0, 0.01));
      for (int i = 0; i < 3; ++i) t.tick(hip);
      ASSERT_NEAR(t.contact.force.z(), 1, 1e-6);
      t.pose(id, {at + Vec3(0, 0.3, 0), Quat::Identity()});
      EXPECT_EQ(t.tick(hip).object, 0u) << "it is 0.3 m away";
    }
  }
}

TEST(ProxyAtRest, IsLetGoByAHandThatLeavesAndBeyondTheEdge) {
  for (const double radius : {0.0, 0.002}) {
    Rest r(radius);
    EXPECT_EQ(r.t.tick(r.hip + Vec3(0, 0, 0.0011)).force, Vec3(Vec3::Zero()));
    r.t.tick(r.hip);
    for (double x = r.hip.x(); x < 0.06; x += 1e-4) r.t.tick(Vec3(x, 0.003, r.hip.z()));
    EXPECT_EQ(r.t.contact.object, 0u) << "beside the box by now";
  }
}

/** Over ridges and hollows alike; a hand 1 mm deep crosses an edge in two ticks of three, or several in each. */
TEST(ProxyInMotion, IsLedOverFacesByFewSweeps) {
  const double wave = 2 * M_PI / 0.012;
  for (const int fineness : {120, 360}) {
    TestMesh mesh = test::heightMesh(
        0.02, fineness, [&](double x, double y) { return 0.0003 * std::sin(wave * x) * std::cos(wave * y); });
    for (const double radius : {0.0, 0.001}) {
      SCOPED_TRACE(::testing::Message() << fineness << ", " << radius);
      TestScene t(radius);
      t.addMesh(mesh.view());
      t.tick(Vec3(-0.015, -0.003, 0.01));
      int sweeps = 0, long_ways = 0;
      constexpr int kTicks = 300;
      for (int i = 0; i < kTicks; ++i) {
        const Vec3 hip(-0.015 + 1e-4 * i, -0.003 + 2.3e-5 * i, radius - 0.001);
        EXPECT_GT(t.tick(hip).force.norm(), 0) << i;
        sweeps += static_cast<int>(t.proxy.effort().sweeps);
        long_ways += t.proxy.effort().sweeps > 2;
      }
      EXPECT_LT(2 * sweeps, (fineness == 120 ? 3 : 4) * kTicks);
      EXPECT_LT(20 * long_ways, kTicks) << "two sweeps are enough for all of a bulge";
    }
  }
}

/** A roof of 30 degrees: the ball lies on its ridge for some ticks, and then rolls off. */
TEST(ProxyInMotion, RollsOffAnEdgeWithoutASecondLook) {
  TestMesh mesh = test::heightMesh(0.02, 8, [&](double x, double) { return -std::abs(x) / std::sqrt(3.0); });
  constexpr double kRadius = 0.002;
  TestScene t(kRadius);
  t.addMesh(mesh.view());
  t.tick(Vec3(-0.004, 0.0011, 0.01));
  const auto tiltOf = [](const Vec3& n) { return std::atan2(std::abs(n.x()), n.z()) * 180 / M_PI; };
  int on_ridge = 0;
  double before = 30;
  for (int i = 0; i < 70; ++i) {
    // As high above each side as a ball half in it.
    const double x = -0.004 + 1.07e-4 * i;
    t.tick(Vec3(x, 0.0011, 0.5 * kRadius / std::cos(M_PI / 6) - std::abs(x) / std::sqrt(3.0)));
    const double tilt = tiltOf(t.contact.normal);
    EXPECT_LE(tilt, 30.01);
    if (before < 29.9) {
      EXPECT_LE(t.proxy.effort().sweeps, 2u) << "at " << x << " m, tilt " << tilt;
    }
    on_ridge += tilt < 29.9;
    before = tilt;
  }
  EXPECT_GE(on_ridge, 8);
}

/** Along an edge of a box, half in the ball, and past the corner where it ends: as deep as the distance tells. */
TEST(ProxyInMotion, AnEdgeHoldsABallAsFarAsItGoes) {
  const Vec3 half(0.02, 0.02, 0.02);
  TestMesh box = test::boxMesh(half);
  constexpr double kRadius = 0.002, kOff = 0.0008;
  TestScene t(kRadius);
  t.addMesh(box.view());
  t.tick(Vec3(0.0101, 0.03, 0.03));
  int beyond = 0;
  for (int i = 0; i < 130; ++i) {
    const Vec3 hip(0.0101 + 9e-5 * i, half.y() + kOff, half.z() + 0.7 * kOff);
    t.tick(hip);
    const double distance = (hip - hip.cwiseMin(half)).norm();
    ASSERT_NEAR(t.contact.depth, std::max(kRadius - distance, 0.0), 1e-9) << hip.x();
    beyond += hip.x() > half.x() && t.contact.object != 0;
  }
  EXPECT_GT(beyond, 10);
}

}  // namespace
}  // namespace hapticd
