/** @file
 * A proxy that rests on a face is held by it without a sweep; not by one that has gone.
 */
#include <gtest/gtest.h>

#include "tests/support/test_mesh.h"
#include "tests/support/test_scene.h"

namespace hapticd {
namespace {

using testing::TestMesh;
using testing::TestScene;

/** Two boxes, their tops at 0 and at -0.5 mm; the first lies under the hand. */
struct Rest {
  TestMesh high = testing::boxMesh(Vec3(0.05, 0.05, 0.01), Vec3(0, 0, -0.01));
  TestMesh low = testing::boxMesh(Vec3(0.05, 0.05, 0.01), Vec3(0, 0, -0.0105));
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
    Command command;
    command.kind = CommandKind::kSetShape;
    auto& order = command.as<SetShape>();
    order = SetShape{};
    order.object = swapped.id;
    order.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    order.shape.mesh = 1;  // The lower box.
    ASSERT_EQ(swapped.t.scene->apply(command), ErrorCode::kOk);
    EXPECT_NEAR(swapped.force(), 0.5, 1e-6);
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
    TestMesh mesh = testing::heightMesh(
        0.02, fineness, [&](double x, double y) { return 0.0003 * std::sin(wave * x) * std::cos(wave * y); });
    for (const double radius : {0.0, 0.001}) {
      SCOPED_TRACE(::testing::Message() << fineness << ", " << radius);
      TestScene t;
      t.addMesh(mesh.view());
      t.proxy.setRadius(radius);
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

}  // namespace
}  // namespace hapticd
