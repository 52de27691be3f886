#include "rt/render/proxy/proxy.h"

#include <gtest/gtest.h>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kPlateStiffness = 1000;

TEST(Proxy, PlaneForceIsStiffnessTimesDepthAtEveryDepth) {
  for (const double depth : {1e-6, 1e-5, 1e-3, 0.1, 1.0}) {
    TestScene t;
    t.add(ShapeKind::kPlane, Vec3::Zero(),
          {Vec3(0, 0, 0.05), Quat(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()))});
    const Vec3 n = Quat(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized())) * Vec3::UnitZ();
    t.tick(Vec3(0, 0, 0.05) + 0.01 * n);
    const SurfaceContact& c = t.tick(Vec3(0, 0, 0.05) - depth * n);
    EXPECT_NEAR(c.force.dot(n) / (kPlateStiffness * depth), 1, 1e-9) << depth;
    EXPECT_NEAR((c.force - c.force.dot(n) * n).norm() / (kPlateStiffness * depth), 0, 1e-9) << depth;
    EXPECT_TRUE(c.touch);
    EXPECT_NEAR(c.depth, depth, 1e-9 * depth);
    EXPECT_LT(c.work, 10u);
  }
}

TEST(Proxy, SphereForceIsRadialAndExact) {
  TestScene t;
  t.add(ShapeKind::kSphere, Vec3(0.05, 0, 0), {Vec3(0.1, 0.2, 0.3), Quat::Identity()});
  const Vec3 c(0.1, 0.2, 0.3);
  t.tick(c + Vec3(0, 0, 0.06));
  for (int i = 0; i < 1000; ++i) {
    const double a = 0.01 * i;
    const Vec3 u(std::sin(a), 0.3 * std::cos(0.7 * a), std::cos(a));
    const Vec3 n = u.normalized();
    const SurfaceContact& s = t.tick(c + 0.049 * n);
    ASSERT_LT((s.force - kPlateStiffness * 0.001 * n).norm(), 1e-9) << i;
  }
}

TEST(Proxy, MeshBoxIsThePrimitiveBox) {
  TestMesh mesh = test::boxMesh(Vec3(0.03, 0.02, 0.01));
  TestScene a, b;
  a.addMesh(mesh.view());
  b.add(ShapeKind::kBox, Vec3(0.03f, 0.02f, 0.01f));
  for (TestScene* t : {&a, &b}) t->tick(Vec3(0, 0, 0.02));
  for (int i = 0; i < 3000; ++i) {
    const double w = 0.003 * i;
    const Vec3 hip = Vec3(0.035 * std::sin(w), 0.024 * std::sin(1.3 * w), 0.008 + 0.003 * std::cos(5 * w));
    const Vec3 fa = a.tick(hip).force, fb = b.tick(hip).force;
    ASSERT_LT((fa - fb).norm(), 1e-9) << i;
  }
}

// A planar device may well move exactly in the plane in which tiles meet.
TEST(Proxy, AHandExactlyBetweenTwoBoxesIsHeldByThem) {
  for (const int axis : {0, 1}) {
    for (const double first : {-0.05, 0.05}) {
      TestScene t;
      for (const double at : {first, -first})
        t.add(ShapeKind::kBox, Vec3::Constant(0.05), {at * Vec3::Unit(axis), Quat::Identity()});
      t.tick({0, 0, 0.06});
      t.tick({0, 0, 0.049});
      for (int i = 0; i < 50; ++i) {  // Along the seam, then across it.
        const Vec3 along = 1e-4 * i * Vec3::Unit(1 - axis), across = 1e-4 * (i - 25) * Vec3::Unit(axis);
        EXPECT_NEAR((t.tick(along + Vec3(0, 0, 0.049)).force - Vec3(0, 0, 1)).norm(), 0, 1e-9) << i;
        EXPECT_NEAR((t.tick(across + Vec3(0, 0, 0.049)).force - Vec3(0, 0, 1)).norm(), 0, 1e-9) << i;
      }
    }
  }
  // Nor does a floor of boxes stop a hand that slides on it without a load.
  TestScene t;
  for (const double at : {-0.05, 0.05})
    t.add(ShapeKind::kBox, Vec3::Constant(0.05), {at * Vec3::UnitX(), Quat::Identity()});
  for (int i = 0; i < 100; ++i) EXPECT_EQ(t.tick({-0.05 + 1e-3 * i, 0, 0.05}).force, Vec3::Zero()) << i;
}

TEST(Proxy, RisingPlatePushesAtEverySpeed) {
  for (const double speed : {0.01, 0.1, 1.0, 5.0}) {
    TestScene t;
    const auto id = t.add(ShapeKind::kBox, Vec3(1, 1, 0.0005), {Vec3(0, 0, -0.02), Quat::Identity()});
    t.tick(Vec3::Zero());
    t.pose(id, {Vec3(0, 0, -0.02), Quat::Identity()}, {Vec3(0, 0, speed), Vec3::Zero()});
    const int ticks = static_cast<int>(0.03 / (speed * test::kTick)) + 2;
    double top = 0;
    for (int i = 0; i < ticks; ++i) {
      const SurfaceContact& c = t.tick(Vec3::Zero());
      top = -0.02 + 0.0005 + speed * test::kTick * i;
      ASSERT_NEAR(c.force.z(), kPlateStiffness * std::max(top, 0.0), 1e-6) << speed << " " << i;
    }
    EXPECT_GT(top, 0.005);
  }
}

TEST(Proxy, StaticFrictionHoldsUntilItsConeAndDynamicFrictionAfter) {
  for (const double depth : {1e-5, 3e-4, 5e-3}) {
    TestScene t;
    t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kPlateStiffness, 0, 0.6, 0.4});
    t.tick(Vec3(0, 0, 0.001));
    t.tick(Vec3(0, 0, -depth));
    bool slipped = false;
    for (int i = 1; i <= 2000; ++i) {
      const double x = 1e-3 * depth * i;
      const SurfaceContact& c = t.tick(Vec3(x, 0, -depth));
      const double ratio = -c.force.x() / c.force.z();
      if (x < 0.6 * depth * (1 - 1e-6)) {
        ASSERT_NEAR(ratio, x / depth, 1e-6) << depth;
        ASSERT_FALSE(c.slip);
      } else if (x > 0.6 * depth * (1 + 1e-6)) {
        ASSERT_NEAR(ratio, 0.4, 1e-6) << depth << " " << i;
        slipped = slipped || c.slip;
      }
    }
    EXPECT_TRUE(slipped);
  }
}

}  // namespace
}  // namespace hapticd
