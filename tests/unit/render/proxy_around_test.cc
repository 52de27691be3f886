/** @file
 * The proxy may go around an edge to a nearer surface; it must never get through a plate or out of a box so.
 */
#include <gtest/gtest.h>

#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;

constexpr double kThick = 0.00005;
constexpr double kBall = 0.001;  ///< Radius of a proxy that is none.

/** A room with walls: an inner and an outer box in one mesh. */
TestMesh roomMesh(const Vec3& half, double wall) {
  TestMesh room = test::boxMesh(half, Vec3::Zero(), true), outer = test::boxMesh(half + Vec3::Constant(wall));
  for (const auto& v : outer.vertices) room.vertices.push_back(v);
  for (const auto& t : outer.triangles) room.addTriangle(t[0] + 8, t[1] + 8, t[2] + 8);
  return room;
}

TEST(ProxyAround, APlateIsNotPassedAtAnyAngleSpeedAndPlace) {
  const double half = 0.02;
  TestMesh mesh = test::boxMesh(Vec3(half, half, kThick / 2));
  MeshView* view = mesh.view();
  Random random(seedOf(11));
  for (int run = 0; run < 2000; ++run) {
    const double mu = run % 2 ? random.in(0, 1) : 0, speed = std::pow(10.0, random.in(-2.5, 0));
    const double radius = run % 5 == 0 ? 0.001 : (run % 5 == 1 ? random.in(0.0001, 0.003) : 0),
                 top = double{static_cast<float>(kThick / 2)} + radius;
    TestScene t(radius);
    const Pose X{random.vector(0.1), random.turn()};
    t.addMesh(view, X, {1000, 0, mu, 0.8 * mu});
    // Anywhere, half of the times within 0.3 mm of the border, but for its own thickness (docs/rendering.md).
    const double rim = kThick, from_rim = run % 4 < 2 ? random.in(rim, 0.0003) : random.in(rim, half);
    Vec3 through((run % 8 < 4 ? 1 : -1) * (half - from_rim), random.in(-half + rim, half - rim), top);
    if (run % 3 == 0) std::swap(through.x(), through.y());
    // Inward or level, so that it is the plate that is met.
    Vec3 along(random.in(-2, 0) * through.x(), random.in(-2, 0) * through.y(), -half * random.in(0.2, 2));
    along.normalize();
    for (double s = -0.001; s < 0.008; s += speed * kTick) {
      const Vec3 x = through + s * along;
      const SurfaceContact& c = t.tick(X * x);
      const Vec3 p = X.inverse() * c.proxy;
      ASSERT_GE(p.z(), top - 1e-8) << run << " at " << s;
      ASSERT_EQ(c.object != 0, x.z() < top) << run << " at " << s;
    }
  }
}

TEST(ProxyAround, ARoomWithThinWallsIsNeverLeft) {
  const Vec3 half(0.01, 0.008, 0.006);
  TestMesh mesh = roomMesh(half, kThick);
  MeshView* view = mesh.view();
  Random random(seedOf(11));
  for (const auto& [mu, radius] :
       {std::pair{0.0, 0.0}, {0.7, 0.0}, {1.5, 0.0}, {0.0, kBall}, {0.7, kBall}, {1.5, kBall}}) {
    TestScene t(radius);
    const Pose X{Vec3(0.1, -0.2, 0.05), random.turn()};
    t.addMesh(view, X, {500, 0, mu, 0.8 * mu});
    Vec3 aim = Vec3::Zero(), x = Vec3::Zero();
    t.tick(X * x);
    for (int i = 0; i < (radius > 0 ? 6000 : 30000); ++i) {
      // Anywhere; and then again into walls, edges and corners, by less than the walls are thick.
      if (i % 40 == 0) aim = half.cwiseProduct(random.vector(1.4));
      if (i % 40 == 20) {
        for (int k = 0; k < 3; ++k) aim[k] = std::copysign(half[k] + random.in(-4, 1) * kThick, random.in(-1, 1));
      }
      x += std::min((aim - x).norm(), std::pow(10.0, random.in(-5.5, -3))) * (aim - x).normalized();
      const Vec3 p = X.inverse() * t.tick(X * x).proxy;
      ASSERT_LE((p.cwiseAbs() - half).maxCoeff() + radius, 1e-8) << mu << " " << radius << " " << i;
    }
  }
}

TEST(ProxyAround, ItDoesNotGetOutByACornerBesideWhichItSticks) {
  // Held by friction on one wall, the hand in the other one, nearest to that one's outside, which does not face it.
  const Vec3 half(0.01, 0.008, 0.006);
  TestMesh mesh = roomMesh(half, kThick);
  MeshView* view = mesh.view();
  Random random(seedOf(11));
  for (int run = 0; run < 1000; ++run) {
    const double mu = random.in(0.3, 2), radius = run % 4 == 0 ? kBall : 0;
    TestScene t(radius);
    t.addMesh(view, {}, {500, 0, mu, mu});
    const Vec3 start = half - Vec3(0.001 + radius, radius + random.in(0.1, 1) * kThick, 0.003);
    const Vec3 touch(half.x() + random.in(0.1, 1) * kThick, start.y(), start.z());
    const Vec3 corner = Vec3(half.x(), half.y(), start.z()) + Vec3(random.in(0, 1), random.in(0, 1), 0) * kThick;
    t.tick(start);
    t.tick(touch);
    for (int i = 0; i <= 20; ++i) {
      const SurfaceContact& c = t.tick(touch + i / 20.0 * (corner - touch));
      ASSERT_LE((c.proxy.cwiseAbs() - half).maxCoeff() + radius, 1e-8) << run << " " << i;
    }
  }
}

TEST(ProxyAround, ABladeKeepsItsSide) {
  // 20 mm high, edge upward, 10 degrees: pressed from one side by up to 5 mm, far from the edge and the ends.
  const double foot = 0.02 * std::tan(5 * M_PI / 180), half = 0.05;
  TestMesh blade;
  for (const double y : {-half, half}) {
    blade.addVertex({-foot, y, 0});
    blade.addVertex({foot, y, 0});
    blade.addVertex({0, y, 0.02});
  }
  blade.addQuad(0, 2, 5, 3);
  blade.addQuad(1, 4, 5, 2);
  blade.addQuad(0, 3, 4, 1);
  blade.addTriangle(0, 1, 2);
  blade.addTriangle(3, 5, 4);
  MeshView* view = blade.view();
  Random random(seedOf(11));
  for (int run = 0; run < 500; ++run) {
    const double mu = run % 2 ? random.in(0, 1) : 0, radius = run % 4 < 2 ? 0 : kBall;
    TestScene t(radius);
    t.addMesh(view, {}, {1000, 0, mu, mu});
    Vec3 x(-0.004, random.in(-0.01, 0.01), random.in(0.004, 0.012));  // It ends 10 mm from the blade's ends.
    t.tick(x);
    const Vec3 step(std::pow(10.0, random.in(-5, -3)), random.in(-1, 1) * 1e-4, 0);
    for (int i = 0; i < 300 && x.x() < 0.005 - foot; ++i) {
      const SurfaceContact& c = t.tick(x += step);
      ASSERT_LT(c.proxy.x(), -radius) << run << " " << i << " at " << x.transpose();
    }
  }
}

TEST(ProxyAround, FrictionTurnsAlongWithTheSurface) {
  // Over an edge of 90 degrees: what part of the normal force is tangential, and where it points, does not jump.
  TestMesh box = test::boxMesh(Vec3(0.02, 0.02, 0.02));
  for (const auto& [mu, radius] : {std::pair(0.2, 0.0), {0.6, 0.0}, {1.0, 0.0}, {0.6, kBall}}) {
    TestScene t(radius);
    t.addMesh(box.view(), {}, {1000, 0, mu, mu});
    const double top = 0.02;
    t.tick(Vec3(0.01, 0.003, top + 2 * kBall));
    Eigen::Vector2d before(0, 0);
    int turned = 0;
    for (int i = 0; i < 1500; ++i) {
      const double a = 0.1 + 1.37 * i / 1500;  // Around the edge, 6 mm from it.
      const Vec3 hip = Vec3(top, 0.003, top) - 0.006 * Vec3(std::cos(a), 1e-3 * i, std::sin(a));
      const SurfaceContact& c = t.tick(hip);
      const Vec3 lag = (c.force - c.force.dot(c.normal) * c.normal) / c.force.dot(c.normal);
      ASSERT_LE(lag.norm(), mu * (1 + 1e-6)) << mu << " " << i;
      // Along the edge, and across it in the sense of the motion.
      const Eigen::Vector2d now(lag.y(), c.normal.z() > 0.5 ? lag.x() : -lag.z());
      if (i > 0) {
        ASSERT_LT((now - before).norm(), 0.02) << mu << " " << i;
      }
      turned += c.normal.x() > 0.5;
      before = now;
    }
    EXPECT_NEAR(turned, 750, 20) << "it gave way to the other face about half way";
  }
}

TEST(ProxyAround, AMeshHoldsABallWhoseHandHasPassedItAsTheBoxDoes) {
  // With friction: of a hand in the air below a plate, on its way past the rim, the nearest point is that edge.
  const Vec3 half(0.03, 0.02, 0.003);
  TestMesh mesh = test::boxMesh(half);
  for (const double radius : {0.0003, 0.0015}) {
    for (const double mu : {0.3, 0.8}) {
      TestScene box, other;
      const hd_material material{1000, 0, mu, 0.7 * mu};
      box.add(ShapeKind::kBox, half, {}, material);
      other.addMesh(mesh.view(), {}, material);
      box.proxy.setRadius(radius);
      other.proxy.setRadius(radius);
      int held = 0;
      for (int i = 0; i < 1000; ++i) {
        const double down = std::min(1.0, i / 400.0), aside = std::max(0.0, (i - 400) / 600.0);
        const Vec3 hip(0.004, 0.012 + 0.01 * aside, 0.02 - 0.05 * down);
        const Vec3 force = box.tick(hip).force;
        ASSERT_NEAR((other.tick(hip).force - force).norm(), 0, 1e-6 * (1 + force.norm())) << radius << " " << i;
        held += hip.y() > half.y() && force.z() > 10;
      }
      EXPECT_GT(held, 20);
    }
  }
}

/** The nearest point of what does not face away is then an edge, beyond which the solid is not. */
TEST(ProxyAround, ABallDoesNotGoAroundToAHandThatIsJustThroughAPlate) {
  const Vec3 half(0.012, 0.018, 0.0045);
  TestMesh mesh = test::boxMesh(half);
  MeshView* view = mesh.view();
  Random random(seedOf(5));
  for (int run = 0; run < 300; ++run) {
    const double radius = random.in(0.002, 0.004), through = std::pow(10.0, random.in(-6, -3.5));
    const double from_rim = random.in(through, 0.001), y = random.in(-0.01, 0.01);
    TestScene box(radius), other(radius);
    box.add(ShapeKind::kBox, half);
    other.addMesh(view);
    for (const Vec3& hip : {Vec3(0, y, 0.02), Vec3(0, y, 0), Vec3(half.x() - from_rim, y, -half.z() - through)}) {
      const Vec3 force = box.tick(hip).force;
      ASSERT_NEAR((other.tick(hip).force - force).norm(), 0, 1e-3) << run;
    }
    EXPECT_GT(other.contact.normal.z(), 0.999) << run << " through by " << through << ", rim " << from_rim;
  }
}

/** In the corner of a floor and a step: the floor is nearest, within the step; over that leads a free way. */
TEST(ProxyAround, OfSeveralSolidsTheNearestThatCanBeReachedIsGoneTo) {
  for (const double radius : {0.0, 0.0005}) {
    TestScene t(radius);
    t.add(ShapeKind::kBox, Vec3(0.02, 0.02, 0.01), {Vec3(0, 0, -0.01), Quat::Identity()});
    t.add(ShapeKind::kBox, Vec3(0.004, 0.02, 0.006), {Vec3(0.004, 0, -0.004), Quat::Identity()});
    t.tick(Vec3(-0.002, 0, 0.003));
    t.tick(Vec3(0.001, 0, -0.0005));
    EXPECT_EQ(t.contact.parts, 2u);
    EXPECT_NEAR((t.contact.proxy - Vec3(-radius, 0, radius)).norm(), 0, 1e-9);
    t.tick(Vec3(0.003, 0, -0.0009));
    EXPECT_NEAR((t.contact.proxy - Vec3(0.003, 0, 0.002 + radius)).norm(), 0, 1e-9) << radius;
  }
}

/** The end of the one solid, to which the hand is nearest, lies within the other, that does not hold the proxy. */
TEST(ProxyAround, ASolidThatDoesNotHoldTheProxyMayHaveTheNearestSurface) {
  for (const double radius : {0.0, 0.0005}) {
    for (const bool first : {false, true}) {
      TestScene t(radius);  // A bar of two boxes that overlap.
      for (const double side : {first ? -1.0 : 1.0, first ? 1.0 : -1.0})
        t.add(ShapeKind::kBox, Vec3(0.025, 0.01, 0.01), {Vec3(0.015 * side, 0, -0.01), Quat::Identity()});
      for (int i = 0; i <= 100; ++i) t.tick(Vec3(0.009, 8e-5 * i, radius - 6e-5 * i));
      EXPECT_NEAR((t.contact.force - Vec3(0, 2 + 1000 * radius, 0)).norm(), 0, 1e-6) << radius << " " << first;
    }
  }
}

/** It is friction of what holds the proxy by which this may be behind, not that of what is nearer by a tenth. */
TEST(ProxyAround, FrictionOfWhatHoldsTheProxyTellsHowMuchNearerIsNearer) {
  for (const double holds : {0.0, 0.6}) {
    for (const double other : {0.0, 0.6}) {
      TestScene t;  // A bar as above, but the one box stands out at the top, the other at the sides.
      t.add(ShapeKind::kBox, Vec3(0.025, 0.0099, 0.01), {Vec3(-0.015, 0, -0.01), Quat::Identity()},
            {1000, 0, holds, holds});
      t.add(ShapeKind::kBox, Vec3(0.025, 0.01, 0.01), {Vec3(0.015, 0, -0.01 - 1e-6), Quat::Identity()},
            {1000, 0, other, other});
      for (int i = 0; i <= 100; ++i) t.tick(Vec3(0.009, 0.0064, 1e-3 - 5e-5 * i));
      EXPECT_NEAR(t.contact.normal.y(), holds > 0 ? 0 : 1, 1e-9) << holds << " " << other;
      EXPECT_NEAR(t.contact.depth, holds > 0 ? 0.004 : 0.0036, 1e-9) << holds << " " << other;
    }
  }
}

TEST(ProxyAround, WhereABallDoesNotFitItLooksForNoWay) {
  // Over waves whose nearest point often lies in a hollow too narrow for the ball.
  TestMesh mesh =
      test::heightMesh(0.02, 80, [](double x, double y) { return 0.0005 * std::sin(600 * x) * std::sin(600 * y); });
  constexpr double kRadius = 0.001;
  TestScene t(kRadius);
  t.addMesh(mesh.view());
  t.tick(Vec3(-0.015, 0.001, 0.005));
  int many = 0, ticks = 0;
  for (double x = -0.015; x < 0.015; x += 1e-5, ++ticks) {
    const double y = 0.001 + 0.3 * x;
    t.tick(Vec3(x, y, 0.0005 * std::sin(600 * x) * std::sin(600 * y) - 0.0004));
    many += t.proxy.effort().visited > 100;
  }
  EXPECT_LT(many, ticks / 20);
}

/** Thrown round a sphere into a rough box: the tangent plane from which it came has been passed, and holds nothing. */
TEST(ProxyAround, WhatWasPassedOnTheWayHoldsNoMore) {
  constexpr double kRadius = 0.02;
  const Vec3 half(0.01, 0.1, 0.01);
  int boxes = 0;
  for (double low = 0; low < 0.05; low += 0.002) {
    for (const double mu : {0.0, 1.0}) {
      SCOPED_TRACE(::testing::Message() << low << " friction " << mu);
      const Vec3 center(0.03, 0, -low);
      TestScene t;
      const std::uint32_t sphere = t.add(ShapeKind::kSphere, Vec3(kRadius, 0, 0));
      const std::uint32_t box = t.add(ShapeKind::kBox, half, {center, Quat::Identity()}, {1000, 0, mu, mu});
      t.tick(Vec3(0, 0, 0.06));
      const SurfaceContact& c = t.tick(Vec3(0.012, 0.001, -0.05));
      const double off_sphere = c.proxy.norm() - kRadius, off_box = ((c.proxy - center).cwiseAbs() - half).maxCoeff();
      EXPECT_GT(off_sphere, -1e-9);
      EXPECT_GT(off_box, -1e-9);
      if (c.object == sphere) {
        EXPECT_LT(off_sphere, 1e-9);
      }
      if (c.object == box) {
        EXPECT_LT(off_box, 1e-9);
      }
      boxes += c.object == box;
    }
  }
  EXPECT_GT(boxes, 10);
}

/** Something on the side of a box bars the way over its edge: the one through the air is looked for, or not, at any
 * turn. */
TEST(ProxyAround, WhereFacesMeetAtRightAnglesRoundingDecidesNothing) {
  Random random(seedOf(7));
  int passed = 0;
  constexpr int kTurns = 200;
  for (int i = 0; i < kTurns; ++i) {
    const Pose X = random.pose(0.1);
    TestScene t;
    t.add(ShapeKind::kBox, Vec3(0.02, 0.02, 0.02), X);
    t.add(ShapeKind::kBox, Vec3(0.001, 0.005, 0.001), X * Pose{Vec3(0.0208, 0, 0.01), Quat::Identity()});
    t.tick(X * Vec3(0.016, 0, 0.03));
    const SurfaceContact& c = t.tick(X * Vec3(0.016, 0, 0));
    passed += (c.proxy - X * Vec3(0.02, 0, 0)).norm() < 1e-9;
  }
  EXPECT_EQ(passed, kTurns);
}

/** Over a fin to the floor beyond it, in an arch as long as may be: no place in the world makes that too long. */
TEST(ProxyAround, FarFromTheOriginAsNearIt) {
  TestMesh mesh = test::heightMesh(0.02, 40, [](double x, double) { return std::abs(x) < 1e-6 ? 0.002 : 0.0; });
  MeshView* view = mesh.view();
  Random random(seedOf(11));
  int over = 0;
  for (int run = 0; run < 300; ++run) {
    const double depth = random.in(0.003, 0.006), y = random.in(-0.01, 0.01);
    double at_origin = 0;
    for (const double far : {0.0, 1e4}) {
      TestScene t;
      const Vec3 p = far * random.vector(1);
      t.addMesh(view, {p, Quat::Identity()});
      t.tick(p + Vec3(-0.004, y, 0.001));
      t.tick(p + Vec3(-0.004, y, -depth));
      t.tick(p + Vec3(0.004, y, -depth));
      const double x = t.contact.proxy.x() - p.x();
      if (far == 0) {
        at_origin = x;
        over += x > 0.003 ? 1 : 0;
      }
      EXPECT_NEAR(x, at_origin, 1e-6) << run << " at " << p.transpose();
    }
  }
  EXPECT_GT(over, 200);
}

}  // namespace
}  // namespace hapticd
