/** @file
 * A hand between two that close on each other: a press that somebody moves, and a body that falls on it.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/base/rotation.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/test_scene.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

constexpr double kPressed = 1000;       // N/m
constexpr double kLargestBall = 0.004;  // In the hand [m].

/**
 * By one tick's motion of what closes, three times it more, and half of how far the hand then is behind, a proxy may
 * come farther from it, no more: proxy_pinch.cc. By `own` the hand moved [m].
 */
double mostAfter(double force, double way, double own) {
  return 1.5 * force + kPressed * (4.5 * way + 1.5 * own) + 1e-6;
}

/** It closes on a hand that lies on a table or hovers over it, over it by up to 2 mm, rests, and opens; in steps or
 * not, the table at rest or heaving. */
void aPressDoesNotKick(unsigned seed) {
  Random random(seed);
  const double radius = random.once(2) ? 0 : random.in(5e-4, kLargestBall), mu = random.once(2) ? 0 : random.in(0, 1);
  test::TestScene t(radius);
  const hd_material material{kPressed, 1, mu, 0.7 * mu};
  Pose X_floor{{0, 0, -0.05}, Quat::Identity()};
  const std::uint32_t floor = t.add(ShapeKind::kBox, {0.1, 0.1, 0.05}, X_floor, material);
  const double tilt = random.once(2) ? 0 : std::pow(10, random.in(-7, -1)), about = random.in(0, 6.3);
  Pose X{{0, 0, 0.06}, fromRotationVector(tilt * Vec3(std::cos(about), std::sin(about), 0))};
  hd_material softer = material;
  if (tilt == 0) softer.stiffness = random.in(100, kPressed);  // In a wedge both press, each with its own.
  const std::uint32_t press = t.add(ShapeKind::kBox, {0.06, 0.06, 0.01}, X, softer);
  const Vec3 hand(0, 0, radius - random.in(-0.003, 0.003));
  t.tick(Vec3(0, 0, 0.02));
  for (int i = 0; i < 50; ++i) t.tick(hand);
  const double before = t.contact.force.z(), way = 1e-3 * std::pow(10, random.in(-2, 0));
  const double lowest = 0.01 - (random.once(2) ? 0 : random.in(0, 0.002));
  const int every = random.once(2) ? 1 : 5, rests = 20;
  const double heaves = random.once(2) ? 0 : way;  // The floor, in a tick.
  double last = before;
  for (double to : {lowest, 0.06}) {
    for (int i = 0, rested = 0; rested < rests; ++i) {
      if (X.p.z() == to) ++rested;
      if (i % every == 0 && X.p.z() != to) {
        X.p.z() = to < X.p.z() ? std::max(to, X.p.z() - way) : std::min(to, X.p.z() + way);
        t.pose(press, X);
      }
      if (heaves > 0) {
        X_floor.p.z() = std::clamp(X_floor.p.z() + random.in(-heaves, heaves), -0.052, -0.048);
        t.pose(floor, X_floor);
      }
      const double force = t.tick(hand).force.norm();
      ASSERT_LT(force, mostAfter(last, way, 0)) << "press at " << X.p.z();
      last = force;
    }
  }
  X_floor.p.z() = -0.05;
  t.pose(floor, X_floor);
  for (int i = 0; i < rests; ++i) t.tick(hand);
  EXPECT_NEAR(t.tick(hand).force.z(), before, 1e-6) << "the hand is on the table as it was";
}

TEST(PinchProperty, APressThatClosesOnAHandDoesNotKickIt) { forSeeds(60, aPressDoesNotKick); }

/** Of its points, none of which is farther than 0.06 m from its center [m/s]. */
double fastest(const RigidBody& body) { return body.twist().v.norm() + 0.06 * body.twist().w.norm(); }

constexpr double kFall = 9.81;  // m/s^2

/** In steps in which the velocity after them moves it, what falls conserves this [J]. */
double energyOf(const RigidBody& body) {
  return body.kineticEnergy() + body.mass() * kFall * (body.com().z() - 0.5e-3 * body.twist().v.z());
}

/** Onto the hand, which lies on the floor or hovers over it. */
void aBodyThatFallsGainsNothing(unsigned seed, int& pressed) {
  Random random(seed);
  test::ToolHouse house("sim://default?hand_stiffness=1000&hand_damping=15");
  const double radius = random.once(2) ? 0 : random.in(5e-4, kLargestBall);
  if (radius > 0) house.send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, radius});
  house.send(CommandKind::kArm, DeviceRef{0});
  house.aim({0, 0, radius - random.in(-0.006, 0.006)});
  house.run(500);

  const ShapeKind kinds[] = {ShapeKind::kBox, ShapeKind::kSphere, ShapeKind::kCylinder, ShapeKind::kCapsule};
  const ShapeKind kind = kinds[random.below(4)];
  const Vec3 size{random.in(0.01, 0.03), random.in(0.01, 0.03), random.in(0.01, 0.03)};
  const double mass = random.in(0.05, 0.5), height = random.in(0.08, 0.12), about = random.in(0, 6.3);
  const double tilt = random.once(2) ? 0 : random.in(0, 1.5);
  const Vec3 at{random.in(-0.02, 0.02), random.in(-0.02, 0.02), height};
  AddObject body = test::object(test::kWall, kind, size, at);
  store(fromRotationVector(tilt * Vec3(std::cos(about), std::sin(about), 0)), body.q);
  house.send(CommandKind::kAddObject, body);
  SetBody order{};
  order.object = test::kWall;
  order.falls = 1;
  order.mass = mass;
  const Mat3 inertia = MassProperties::ofBox(mass, Vec3::Constant(0.05)).inertia_O;
  for (int i = 0; i < 3; ++i) order.inertia[i] = inertia(i, i);
  house.send(CommandKind::kSetBody, order);
  house.run(20);
  house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -kFall}});

  const RigidBody& rigid = house.servo->cycle().bodies().body(0).body;
  Vec3 hand = house.out().pose.p;
  double last = house.out().contact.force.norm(), given = house.out().contact.stored;
  for (int i = 0; i < 1000; ++i) {
    const double before = fastest(rigid);
    house.run(1);
    const double speed = std::max(before, fastest(rigid));
    const double force = house.out().contact.force.norm(), own = (house.out().pose.p - hand).norm();
    given += std::max(0.0, (hand - house.out().pose.p).dot(house.out().contact.force));
    hand = house.out().pose.p;
    ASSERT_LT(force, mostAfter(last, 1e-3 * (speed + 1e-3 * kFall), own)) << i;
    ASSERT_LT(energyOf(rigid) - mass * kFall * height, given + 2e-4) << i;
    if (house.out().contact.object == test::kWall) ++pressed;
    last = force;
  }
}

TEST(PinchProperty, ABodyThatFallsOnAHandGainsNothingAndDoesNotKickIt) {
  int pressed = 0;
  // Which got 2 to 9 mJ from a proxy that they had pushed far out of a wedge in a tick.
  forSeeds({591u, 807u, 1842u}, 40, [&](unsigned seed) { aBodyThatFallsGainsNothing(seed, pressed); });
  EXPECT_GT(pressed, 1000);
}

}  // namespace
}  // namespace hapticd
