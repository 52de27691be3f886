// A proxy that shares friction with a twist: where it sticks, and how far it comes back, by the thesis's closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestScene;

constexpr double kGroundStill = 0.8, kGroundSliding = 0.6, kGroundStiffness = 1000;
constexpr double kTwistDepth = 2e-3, kTwistArm = 6e-3;  // Of the hand below the floor, of the fingertip [m].

/** A hand that presses on a floor, and goes aside from there. */
struct Twisted {
  Twisted() {
    t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {kGroundStiffness, 0, kGroundStill, kGroundSliding});
    t.tick({0, 0, 1e-3});
    t.tick({0, 0, -kTwistDepth});
  }
  /** So far, with a moment that needs so much of static friction: how far the proxy stays behind. */
  double lag(double aside, double share, double arm = kTwistArm) {
    const double moment = share * kGroundStill * kGroundStiffness * kTwistDepth * kTwistArm;
    t.proxy.bear({moment, arm});
    const SurfaceContact& c = t.tick({aside, 0, -kTwistDepth});
    EXPECT_TRUE(isFinite(c.force));
    EXPECT_NEAR(c.depth, kTwistDepth, 1e-9);
    EXPECT_NEAR(c.proxy.y(), 0, 1e-12);
    return aside - c.proxy.x();
  }
  TestScene t;
};

/** Eq. 2.48: x^2 + y^2 = 1. */
TEST(ProxyTwist, ItSticksWithinTheEllipse) {
  for (const double y : {0.0, 0.3, 0.6, 0.95}) {
    const double most = kGroundStill * kTwistDepth * std::sqrt(1 - y * y);
    EXPECT_NEAR(Twisted().lag(0.999 * most, y), 0.999 * most, 1e-9) << y;
    Twisted beyond;
    EXPECT_LT(beyond.lag(1.001 * most, y), 0.99 * most) << y;
    EXPECT_TRUE(beyond.t.contact.slip);
  }
}

/** Eq. 2.50: to r / sqrt(x^2 + y^2), with what dynamic friction bears; and on, tick by tick. */
TEST(ProxyTwist, FromBeyondItComesBackAlongTheLineToTheGoal) {
  for (const double y : {0.0, 0.4, 0.9, 1.5}) {
    Twisted hand;
    const double y_sliding = y * kGroundStill / kGroundSliding;
    double aside = 1.1 * kGroundStill * kTwistDepth, r = aside;
    for (int i = 0; i < 20; ++i) {
      const double x = r / (kGroundSliding * kTwistDepth);
      const double left = std::max(1.0, std::hypot(x, y_sliding));
      const double lag = hand.lag(aside, y);
      ASSERT_NEAR(lag, r / left, 1e-9) << y << " in tick " << i;
      aside += 3e-4;
      r = lag + 3e-4;
    }
  }
}

/** In a corner of two walls it is what both press with that bears the twist, whichever was touched first. */
TEST(ProxyTwist, TheEllipseInACornerIsThatOfAllThatPresses) {
  const Quat to_x(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));  // A wall that faces x.
  for (const bool wall_first : {true, false}) {
    for (const double share : {0.3, 0.6, 0.95}) {
      for (const double beside : {1e-4, 1.05 * kTwistDepth}) {
        TestScene t;
        const auto wall = t.add(ShapeKind::kPlane, Vec3::Zero(), {Vec3::Zero(), to_x}, {500, 0, 0, 0});
        const auto floor = t.add(ShapeKind::kPlane, Vec3::Zero(), {}, {2000, 0, 0, 0});
        const Vec3 hip(-beside, 0, -kTwistDepth);
        t.tick({1e-3, 0, 1e-3});
        t.tick(wall_first ? Vec3(hip.x(), 0, 1e-3) : Vec3(1e-3, 0, hip.z()));
        t.tick(hip);
        t.material(wall, {500, 0, kGroundStill, kGroundSliding});
        t.material(floor, {2000, 0, kGroundStill, kGroundSliding});
        t.tick(hip);
        ASSERT_EQ(t.contact.object, wall_first ? wall : floor);
        const double pressed = t.contact.stiffness * t.contact.depth;
        ASSERT_NEAR(pressed, std::hypot(4, 500 * beside), 1e-3);
        t.proxy.bear({share * kGroundStill * pressed * kTwistArm, kTwistArm});
        const double most = kGroundStill * t.contact.depth * std::sqrt(1 - share * share);
        const double lag = 0.999 * most - t.tick(hip + Vec3(0, 0.999 * most, 0)).proxy.y();
        EXPECT_NEAR(lag, 0.999 * most, 1e-9) << wall_first << " " << share << " " << beside;
        EXPECT_FALSE(t.contact.slip);
        t.tick(hip + Vec3(0, 1.001 * most, 0));
        EXPECT_TRUE(t.contact.slip) << wall_first << " " << share << " " << beside;
      }
    }
  }
}

/** What bears nothing of a twist leaves nothing: without an arm, or hardly pressed. */
TEST(ProxyTwist, ATwistThatNothingBearsTakesAllOfFriction) {
  EXPECT_NEAR(Twisted().lag(1e-3, 0.1, 0), 0, 1e-9);
  EXPECT_NEAR(Twisted().lag(1e-3, 1e6), 0, 1e-8);
  EXPECT_NEAR(Twisted().lag(1e-3, 0, 0), 1e-3, 1e-9) << "but no twist takes none";
}

}  // namespace
}  // namespace hapticd
