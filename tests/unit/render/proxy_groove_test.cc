/** @file
 * A ball between two surfaces, or in a corner of several: it comes to its place in few sweeps, and that is its place.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kGrooveBall = 0.002;  // [m]

/** Two blocks, tops at z = 0, with a slot between them that opens toward x: a ball lies on both of its edges. */
struct Slot {
  static constexpr double kHalfGap = 0.001, kYaw = 0.07;
  TestMesh block = test::boxMesh(Vec3(0.05, 0.02, 0.01), Vec3(0, 0.02, -0.01));
  TestScene t;
  Vec3 along[2];  ///< Of each edge, unit;
  Vec3 on[2];     ///< and a point of it.

  Slot() {
    for (const int i : {0, 1}) {
      const double side = i == 0 ? 1 : -1;
      const Pose X{Vec3(0, side * kHalfGap, 0),
                   Quat(Eigen::AngleAxisd((i == 0 ? 0 : M_PI) + side * kYaw, Vec3::UnitZ()))};
      t.addMesh(block.view(), X);
      along[i] = X.q * Vec3::UnitX();
      on[i] = X.p;
    }
    t.proxy.setRadius(kGrooveBall);
  }
  [[nodiscard]] Vec3 away(int i, const Vec3& x) const {
    const Vec3 d = x - on[i];
    return d - along[i].dot(d) * along[i];
  }
};

TEST(ProxyInAGroove, SlidesAlongTwoEdgesInOneWay) {
  Slot s;
  s.t.tick(Vec3(-0.003, 0, 0.01));
  int sweeps = 0;
  constexpr int kTicks = 80;
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip(-0.003 + 1e-4 * i, 0.0001, 0.0008);
    const Vec3 at = s.t.tick(hip).proxy;
    const Vec3 a = s.away(0, at), b = s.away(1, at);
    ASSERT_NEAR(a.norm(), kGrooveBall, 1e-9) << i;
    ASSERT_NEAR(b.norm(), kGrooveBall, 1e-9) << i;
    // Nearest to the hip of all places on both edges.
    EXPECT_NEAR((at - hip).normalized().dot(a.cross(b).normalized()), 0, 1e-6) << i;
    sweeps += static_cast<int>(s.t.proxy.effort().sweeps);
  }
  EXPECT_LE(sweeps, 2 * kTicks + 3);
}

/** However far the hand was taken along at once. */
TEST(ProxyInAGroove, FollowsAHandThatLeaps) {
  for (const double leap : {0.002, 0.005, 0.009}) {
    Slot s;
    s.t.tick(Vec3(-0.004, 0, 0.01));
    for (int i = 0; i < 3; ++i) s.t.tick(Vec3(-0.004, 0, 0.0008));
    const Vec3 hip(-0.004 + leap, 0.0001, 0.0008);
    const Vec3 at = s.t.tick(hip).proxy;
    const Vec3 a = s.away(0, at), b = s.away(1, at);
    EXPECT_NEAR((at - hip).normalized().dot(a.cross(b).normalized()), 0, 1e-6) << leap;
    EXPECT_LE(s.t.proxy.effort().sweeps, 6u) << leap;
  }
}

/** Between three balls, nearest to a hand that does not point to the middle: a point as far from each as they are
 * thick. */
TEST(ProxyInAGroove, LiesOnThreeBallsAtOnce) {
  constexpr double kBall = 0.005, kOff = 0.0053;
  TestScene t;
  Vec3 center[3];
  for (int i = 0; i < 3; ++i) {
    center[i] = kOff * Vec3(std::cos(2 * M_PI / 3 * i), std::sin(2 * M_PI / 3 * i), 0);
    t.add(ShapeKind::kSphere, Vec3(kBall, 0, 0), {center[i], Quat::Identity()});
  }
  t.proxy.setRadius(kGrooveBall);
  t.tick(Vec3(0.0002, 0.0001, 0.02));
  int sweeps = 0;
  constexpr int kTicks = 60;
  const double height = std::sqrt((kBall + kGrooveBall) * (kBall + kGrooveBall) - kOff * kOff);
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip(0.0003 * std::cos(0.1 * i), 0.0003 * std::sin(0.1 * i), height - 0.002);
    EXPECT_LT((t.tick(hip).proxy - Vec3(0, 0, height)).norm(), 1e-8) << i;
    sweeps += static_cast<int>(t.proxy.effort().sweeps);
  }
  EXPECT_LE(sweeps, 4 * kTicks);
}

/** Through its middle, all but: the nearest place is on the far side now, and the way leads there round the outside. */
TEST(ProxyOnACurve, GoesAllTheWayRound) {
  for (const double radius : {0.0, kGrooveBall}) {
    for (const double aside : {1e-3, 1e-6, 1e-9}) {
      TestScene t(radius);
      t.add(ShapeKind::kSphere, Vec3(0.01, 0, 0));
      t.tick(Vec3(0, 0, 0.02));
      t.tick(Vec3(0, 0, 0.005));
      const Vec3 hip(aside, 0, -0.005);
      EXPECT_LT((t.tick(hip).proxy - (0.01 + radius) * hip.normalized()).norm(), 1e-9) << aside;
      EXPECT_LE(t.proxy.effort().sweeps, 16u) << aside;
    }
  }
}

/**
 * In the groove of a floor and a sphere, a circle, a hand that goes through the middle is nearest to the far side: the
 * ring is gone round in a tick or two, though next to nothing tells where to.
 */
TEST(ProxyInAGroove, GoesAllTheWayRound) {
  constexpr double kBall = 0.03, kHigh = 0.0144, kDeep = 0.0134;
  for (const double radius : {0.0, kGrooveBall}) {
    const double ring = std::sqrt(std::pow(kBall + radius, 2) - std::pow(kHigh - radius, 2));
    for (const double aside : {2e-3, 5e-4, 1e-4, 1e-5}) {
      TestScene t(radius);
      t.add(ShapeKind::kPlane, Vec3::Zero());
      t.add(ShapeKind::kSphere, Vec3(kBall, 0, 0), {Vec3(0, 0, kHigh), Quat::Identity()});
      t.tick(Vec3(-ring - 0.01, 0, 0.01));
      for (int i = 0; i < 2; ++i) t.tick(Vec3(-0.9 * ring, 0, -0.002));
      EXPECT_LT((t.contact.proxy - Vec3(-ring, 0, radius)).norm(), 1e-9);
      const Vec3 toward(std::cos(0.5), std::sin(0.5), 0), hip = aside * toward - kDeep * Vec3::UnitZ();
      for (int i = 0; i < 2; ++i) {
        t.tick(hip);
        EXPECT_LE(t.proxy.effort().sweeps, 26u) << radius << " " << aside;
      }
      EXPECT_LT((t.contact.proxy - (ring * toward + radius * Vec3::UnitZ())).norm(), 1e-9) << radius << " " << aside;
    }
  }
}

/** What lies in a corner rests on both of its walls: neither alone decides that it slips. At rest and carried along. */
TEST(ProxyInAGroove, StaticFrictionHoldsWhatLiesInACorner) {
  constexpr double kStatic = 0.8, kDepth = 0.002, kBy = 4e-6, kWide = 0.1;
  for (const bool mesh : {false, true}) {
    for (const double radius : {0.0, kGrooveBall}) {
      for (const double speed : {0.0, 0.05}) {
        for (const double angle : {0.6, 0.8, 1.0}) {  // Of the push in the corner: no wall alone holds it.
          SCOPED_TRACE(testing::Message() << mesh << " radius " << radius << " speed " << speed << " angle " << angle);
          TestMesh room = test::boxMesh(Vec3::Constant(kWide), Vec3(kWide, 0, kWide), true);
          TestScene t(radius);
          const hd_material rough{1000, 0, kStatic, 0.3};
          const std::uint32_t corner = t.add(ShapeKind::kGroup, Vec3::Zero());
          if (mesh) {
            t.add(ShapeKind::kMesh, Vec3::Zero(), {}, rough, HD_OBJECT_ENABLED, corner, room.view());
          } else {
            const Quat to_x(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));
            t.add(ShapeKind::kPlane, Vec3::Zero(), {}, rough, HD_OBJECT_ENABLED, corner);
            t.add(ShapeKind::kPlane, Vec3::Zero(), {Vec3::Zero(), to_x}, rough, HD_OBJECT_ENABLED, corner);
          }
          const Vec3 from(0.03, 0, 0.03), in(radius - kDepth * std::sin(angle), 0, radius - kDepth * std::cos(angle));
          const Twist V{Vec3(0, 0.3 * speed, speed), Vec3::Zero()};
          t.tick(from);
          t.pose(corner, {}, V);
          Vec3 carried = Vec3::Zero();
          const auto tick = [&](const Vec3& x) {
            t.tick(x + carried);
            carried += test::kTick * V.v;
            return t.contact.proxy.y() - t.scene->find(corner)->X_WO.p.y();
          };
          for (int i = 0; i <= 200; ++i) tick(from + std::min(1.0, i / 100.0) * (in - from));
          EXPECT_FALSE(t.contact.slip);
          for (int i = 0; i * kBy < 0.99 * kStatic * kDepth; ++i)
            ASSERT_NEAR(tick(in + Vec3(0, i * kBy, 0)), 0, 1e-9) << i;
          EXPECT_GT(tick(in + Vec3(0, 1.01 * kStatic * kDepth, 0)), kDepth / 4);
          EXPECT_TRUE(t.contact.slip);
        }
      }
    }
  }
}

struct Effort {
  double sweeps = 0;  ///< A tick.
  double many = 0;    ///< The share of ticks with more than some.
  double turns = 0;   ///< Of tangent planes, of a tick that turns any.
};

/** Of a ball that strokes eight meshes of (0.04 m)^2 with waves, and the heights of their corners thrown about. */
Effort strokeRoughGround(int fineness, double rough, unsigned many) {
  Effort sum;
  int ticks = 0, turned = 0;
  for (const unsigned seed : seeds(8)) {
    std::mt19937 random(seed);
    TestMesh mesh = test::heightMesh(0.02, fineness, [&](double x, double y) {
      return 0.0003 * std::sin(500 * x) * std::cos(500 * y) + rough * (random() * 0x1p-31 - 1);
    });
    TestScene t(0.001);
    t.addMesh(mesh.view());
    t.tick(Vec3(-0.015, -0.003, 0.01));
    for (int i = 0; i < 300; ++i, ++ticks) {
      t.tick(Vec3(-0.015 + 1e-4 * i, -0.003 + 2.3e-5 * i, 0));
      sum.sweeps += t.proxy.effort().sweeps;
      sum.many += t.proxy.effort().sweeps > many;
      sum.turns += t.proxy.effort().turns;
      turned += t.proxy.effort().turns > 0;
    }
  }
  return {sum.sweeps / ticks, sum.many / ticks, sum.turns / turned};
}

/**
 * Round a sphere that is sunk in a floor, in the circle where they meet: on the border of the cone about where it would
 * be without friction, and the force is steady when the hand is.
 */
TEST(ProxyInAGroove, RubsRoundASunkenSphereInFewSweeps) {
  constexpr double kStiffness = 1000;
  int slid = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    const double mu = random.in(0.1, 0.8), radius = random.in(0.01, 0.05), low = random.in(-0.6, 0.2) * radius;
    TestScene t(random.once(2) ? 0 : random.in(5e-4, 4e-3));
    const bool meshed = random.once(2);
    TestMesh floor = test::boxMesh(Vec3(0.2, 0.2, 0.02), Vec3(0, 0, -0.02));
    t.add(meshed ? ShapeKind::kMesh : ShapeKind::kPlane, Vec3::Zero(), {}, {kStiffness, 0, mu, 0.7 * mu},
          HD_OBJECT_ENABLED, 0, meshed ? floor.view() : nullptr);
    t.add(ShapeKind::kSphere, {radius, 0, 0}, {Vec3(0, 0, low), Quat::Identity()}, {kStiffness, 0, mu, 0.7 * mu});
    const double ball = t.proxy.radius(), grown = radius + ball;
    const double circle = std::sqrt(grown * grown - (ball - low) * (ball - low));
    const double h = random.in(0.6, 0.95) * circle, under = random.in(0.1, 0.3) * circle, step = random.in(0.002, 0.02);
    t.tick(Vec3(0, 0, 0.3));
    for (int i = 0; i <= 100; ++i) t.tick(Vec3(2 * circle + (h - 2 * circle) * i / 100, 0, ball - under));
    Vec3 force = Vec3::Zero();
    for (int i = 0; i < 200; ++i) {
      const double angle = step * std::min(i, 180);
      const SurfaceContact& c = t.tick({h * std::cos(angle), h * std::sin(angle), ball - under});
      ASSERT_LE(t.proxy.effort().sweeps, 20u) << i;
      if (c.slip && i > 60 && i < 180) {
        const Vec3 lag = c.pull - c.depth * c.normal;
        ASSERT_LE(lag.norm(), 0.7 * mu * c.depth * (1 + 1e-6)) << i;
        ASSERT_GE(lag.norm(), 0.7 * mu * c.depth * 0.99) << i;  // Where the normal turns it is left a little inside.
        ++slid;
      }
      if (i > 181) {
        ASSERT_NEAR((c.force - force).norm(), 0, 1e-6);
      }
      force = c.force;
    }
  });
  EXPECT_GT(slid, drawn(3000));
}

/** Over ground as rough as its triangles are large: often three of them and more hold the ball. */
TEST(ProxyInAGroove, CornersTakeFewSweeps) {
  const Effort effort = strokeRoughGround(80, 2e-4, 8);
  // At 51 times as many seeds 2.66 to 3.24, and one in 32 to one in 19; by the planes of what was met alone 3.76 to
  // 4.16, and one in 14 to one in 9.6.
  EXPECT_LT(effort.sweeps, 3.3);
  EXPECT_LT(effort.many, 1.0 / 18);
  EXPECT_LT(effort.turns, 10.5);  // 8.8 to 9.6; guessed from one turn to the next 11.2 to 12.5.
}

TEST(ProxyInAGroove, GrooveAfterGrooveTakesFewSweeps) {
  const Effort effort = strokeRoughGround(160, 2e-5, 2);
  EXPECT_LT(effort.sweeps, 1.95);  // 1.82, and 0.14 have many; by the planes of what was met alone 2.57 and 0.29.
  EXPECT_LT(effort.many, 0.17);
  EXPECT_LT(effort.turns, 5.0);  // 4.3 to 4.7; guessed 5.5 to 5.8.
}

/** Slid off a solid and met by a wall in the same tick, a hand is held by the wall alone: what has it does not matter.
 */
TEST(ProxyInAGroove, ASolidThatWasSlidOffHoldsNobodyBesideAWall) {
  constexpr double kHalf = 0.02;
  for (const ShapeKind kind : {ShapeKind::kBox, ShapeKind::kCylinder, ShapeKind::kMesh}) {
    for (const double radius : {0.0, 0.001}) {
      TestMesh mesh = test::boxMesh(Vec3::Constant(kHalf));
      TestScene t(radius);
      t.add(kind, Vec3::Constant(kHalf), {}, {1000, 0, 0, 0}, HD_OBJECT_ENABLED, 0, mesh.view());
      t.add(ShapeKind::kBox, {0.02, 0.05, 0.05}, {Vec3(0.045, 0, 0), Quat::Identity()});
      t.tick({0, 0, 0.04});
      t.tick({0, 0, kHalf + radius - 0.005});
      t.tick({0.035, 0, kHalf + radius - 0.008});
      EXPECT_NEAR((t.contact.force - Vec3(-10 - 1000 * radius, 0, 0)).norm(), 0, 1e-6)
          << static_cast<int>(kind) << " " << radius << " " << t.contact.force.transpose();
    }
  }
}

}  // namespace
}  // namespace hapticd
