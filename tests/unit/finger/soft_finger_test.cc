// A soft finger on its own, whose contact the test makes up: what it bears, against closed forms.
#include "rt/finger/soft_finger.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

constexpr double kDt = 1e-3;
constexpr double kFloorStiffness = 1000, kFloorStill = 0.8, kFloorSliding = 0.6;  // Of what is touched.

SetFinger usual() {
  SetFinger out{};
  out.law = static_cast<std::uint32_t>(PadLaw::kLinear);
  out.radius = FingertipConstants::kRadius;
  out.arm = FingertipConstants::kArm;
  out.stiffness = 0.1;
  return out;
}

Quat aboutZ(double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ())); }

/** A finger that comes from above to a thing which it touches with 2 N. */
class SoftFingerTest : public ::testing::Test {
 protected:
  SoftFingerTest() : thing(scene.add(ShapeKind::kBox, Vec3::Constant(0.02))) {
    scene.scene->advance(kDt);
    contact.object = thing;
    contact.normal = Vec3::UnitZ();
    contact.stiffness = kFloorStiffness;
    contact.friction = {kFloorStill, kFloorSliding};
    press(2);
    finger.set(usual());
  }
  /** With that much, and with friction keeping back a lag across [N], [m]. */
  void press(double force, const Vec3& lag = Vec3::Zero()) {
    contact.depth = force / kFloorStiffness;
    contact.pull = contact.depth * contact.normal + lag;
  }
  /** A tick with hand and thing turned so far about z. */
  FingerForces tick(double hand = 0, double object = 0) {
    scene.pose(thing, {Vec3::Zero(), aboutZ(object)});
    scene.scene->advance(kDt);
    load = finger.turn(*scene.scene, aboutZ(hand));
    return finger.settle(*scene.scene, contact, motion, kDt);
  }
  double bears(double coefficient) const {
    return coefficient * kFloorStiffness * contact.depth * FingertipConstants::kArm;
  }

  test::TestScene scene;
  std::uint32_t thing;
  SurfaceContact contact;
  SoftFinger finger;
  FingerMotion motion{};
  TwistLoad load;
};

TEST(SoftFingerOrder, IsValidInItsRangesAndNotBeyond) {
  ASSERT_TRUE(SoftFinger::valid(usual()));
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const auto check = [&](double SetFinger::*field, double most, bool zero) {
    SetFinger order = usual();
    const auto is = [&](double x) {
      order.*field = x;
      return SoftFinger::valid(order);
    };
    EXPECT_TRUE(is(most));
    EXPECT_TRUE(is(1e-300));
    EXPECT_EQ(is(0), zero);
    for (const double x : {std::nextafter(most, inf), -1e-300, -1.0, nan, inf, -inf}) EXPECT_FALSE(is(x)) << x;
    order.law = static_cast<std::uint32_t>(PadLaw::kNone);
    EXPECT_TRUE(SoftFinger::valid(order)) << "a point, with anything";
  };
  check(&SetFinger::radius, SoftFinger::kMostArm, false);
  check(&SetFinger::arm, SoftFinger::kMostArm, true);
  check(&SetFinger::stiffness, SoftFinger::kMostStiffness, false);
  check(&SetFinger::damping, SoftFinger::kMostDamping, true);
  check(&SetFinger::cue, SoftFinger::kMostCue, true);
  for (std::uint32_t law = 0; law < 10; ++law) {
    SetFinger order = usual();
    order.law = law;
    EXPECT_EQ(SoftFinger::valid(order), law <= 5) << law;
  }
}

TEST_F(SoftFingerTest, TheTwistIsOfTheThingAgainstTheHandSinceTheyTouched) {
  EXPECT_EQ(tick(0.7, 0.3).moment, 0) << "however they stood";
  EXPECT_NEAR(tick(0.7, 0.34).moment, 0.1 * 0.04, 1e-12);
  EXPECT_NEAR(tick(0.75, 0.34).moment, -0.1 * 0.01, 1e-12);
  EXPECT_NEAR(load.moment, 0.1 * 0.01, 1e-12) << "and the proxy hears of it before it looks";
  EXPECT_EQ(load.arm, FingertipConstants::kArm);
}

TEST_F(SoftFingerTest, LeftLostOrTakenOffItBeginsAnew) {
  for (int way = 0; way < 5; ++way) {
    finger.set(usual());
    (void)tick();
    (void)tick(2);
    ASSERT_TRUE(finger.turning());
    ASSERT_NE(finger.twist(), 0);
    const SurfaceContact before = contact;
    if (way == 0) contact.object = 0;
    if (way == 1) contact.object = makeObjectId(77, 1);  // That is in no scene.
    if (way == 2) contact.stiffness = 0;
    if (way < 3) {
      const FingerForces out = tick(2);
      EXPECT_EQ(out.moment, 0) << way;
      EXPECT_TRUE(out.force.isZero(0) && out.cue.isZero(0)) << way;
    }
    if (way == 3) finger.reset();
    if (way == 4) finger.set(SetFinger{});
    EXPECT_EQ(finger.twist(), 0) << way;
    EXPECT_FALSE(finger.turning()) << way;
    contact = before;
    finger.set(usual());
    EXPECT_EQ(tick(2.01).moment, 0) << way << ": what turned meanwhile is no twist";
  }
}

TEST_F(SoftFingerTest, AnotherOrderLeavesWhatIsTwisted) {
  (void)tick();
  (void)tick(-0.05);
  SetFinger stiffer = usual();
  stiffer.stiffness = 0.15;
  finger.set(stiffer);
  EXPECT_NEAR(tick(-0.05).moment, 0.15 * 0.05, 1e-12);
}

/** Static friction until it turns, dynamic until it rests. */
TEST_F(SoftFingerTest, WhatTurnsIsHeldByLessThanWhatSticks) {
  for (const bool coupled : {true, false}) {
    SetFinger order = usual();
    order.flags = coupled ? 0U : 0U + kFingerUncoupled;
    finger.set(order);
    finger.reset();
    (void)tick();
    const double sticks = 0.99 * bears(kFloorStill) / order.stiffness;
    EXPECT_NEAR(tick(-sticks).moment, 0.99 * bears(kFloorStill), 1e-12);
    EXPECT_FALSE(finger.turning());
    EXPECT_NEAR(tick(-1.02 * sticks).moment, bears(kFloorSliding), 1e-12);
    EXPECT_TRUE(finger.turning());
    EXPECT_NEAR(tick(-1.03 * sticks).moment, bears(kFloorSliding), 1e-12);
    EXPECT_TRUE(finger.turning()) << "on, though static friction would bear it";
    EXPECT_LT(tick(-1.029 * sticks).moment, bears(kFloorSliding));
    EXPECT_FALSE(finger.turning()) << "back";
    // One that slides has no static friction left for its twist, where they share it.
    contact.slip = true;
    (void)tick(-1.04 * sticks);
    EXPECT_EQ(finger.turning(), coupled);
    contact.slip = false;
  }
}

TEST_F(SoftFingerTest, WhatIsAcrossLeavesTheRestOfTheEllipse) {
  const double x = 0.6;  // Of static friction.
  press(2, {x * kFloorStill * 2 / kFloorStiffness, 0, 0});
  (void)tick();
  (void)tick(1);
  const double y = x * kFloorStill / kFloorSliding;  // Of dynamic friction.
  EXPECT_NEAR(finger.twist() * -0.1, bears(kFloorSliding) * std::sqrt(1 - y * y), 1e-12);
  SetFinger order = usual();
  order.flags = kFingerUncoupled;
  finger.set(order);
  (void)tick(2);
  EXPECT_NEAR(finger.twist() * -0.1, bears(kFloorSliding), 1e-12) << "all of it";
  EXPECT_EQ(load.moment, 0);
}

TEST_F(SoftFingerTest, WithoutAnArmItAsksNothingOfFriction) {
  SetFinger order = usual();
  order.arm = 0;
  finger.set(order);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(tick(0.1 * i).moment, 0);
    EXPECT_EQ(load.moment, 0);
  }
}

/** Spring and viscosity of a twist stop a light body within a tick at most, with all fingers that may hold it. */
TEST_F(SoftFingerTest, ALightBodyIsTurnedBackBySoMuch) {
  SetFinger order = usual();
  order.stiffness = 100;
  finger.set(order);
  press(1000);
  for (const double inertia : {1e-2, 1e-3, 1e-4}) {
    for (const int fingers : {1, 3}) {
      motion.body = Mobility::free(0.1, inertia * Mat3::Identity());
      motion.fingers = fingers;
      finger.reset();
      (void)tick();
      const double k = std::min(100.0, inertia / (fingers * kDt * (kDt + SoftFinger::kTwistRetardation)));
      EXPECT_NEAR(tick(-1e-3).moment, 1e-3 * k, 1e-9) << inertia << ' ' << fingers;
    }
  }
}

TEST_F(SoftFingerTest, TheTwistIsViscousWithinFriction) {
  (void)tick();
  motion.w_object = {3, -2, 0.5};
  motion.hand.w = {1, 1, -0.25};
  const double viscous = 0.1 * SoftFinger::kTwistRetardation * 0.75;
  EXPECT_NEAR(tick(0.01).moment, -1e-3 + viscous, 1e-12);
  for (const double sign : {1.0, -1.0}) {
    motion.w_object.z() = 1e3 * sign;
    EXPECT_NEAR(tick(0.01).moment, sign * bears(kFloorStill), 1e-12);
  }
  motion.w_object.z() = 0.5;
  EXPECT_NEAR(tick(1).moment, -bears(kFloorSliding), 1e-12) << "and what turns is not viscous";
}

/** Of the pad: damping times what the thing moves across the normal against the hand. */
TEST_F(SoftFingerTest, ThePadIsViscousAcrossTheNormal) {
  SetFinger order = usual();
  order.damping = 2;
  finger.set(order);
  contact.velocity = contact.at_hip = Vec3{0.03, 0.01, 0.5};
  motion.hand.v = {-0.02, 0.05, 0.2};
  EXPECT_TRUE(tick().force.isZero(0)) << "on what nothing moves there is none";
  motion.body = Mobility::free(1, 1e-3 * Mat3::Identity());
  FingerForces out = tick();
  EXPECT_LT((out.force - 2 * Vec3(0.05, -0.04, 0)).norm(), 1e-12);
  EXPECT_EQ(out.damping, 2) << "which the guard is told";
  motion.hand.v = {0.03, 0.01, 0.2};
  EXPECT_TRUE(tick().force.isZero(0)) << "nothing moves across";
  motion.hand.v = {-0.02, 0.05, 0.2};
  contact.slip = true;
  EXPECT_TRUE(tick().force.isZero(0)) << "nor where it slides";
}

/** It stops a light body within a tick, where it is touched, with all the fingers that may hold it. */
TEST_F(SoftFingerTest, ThePadStopsALightBodyAndNoMore) {
  SetFinger order = usual();
  order.damping = 100;
  finger.set(order);
  press(1000);
  contact.velocity = contact.at_hip = Vec3{0.01, 0, 0};
  motion.r = {0, 0.02, 0};
  for (const int fingers : {1, 2}) {
    const double mass = 0.01, inertia = 1e-5;
    motion.body = Mobility::free(mass, inertia * Mat3::Identity());
    motion.fingers = fingers;
    const double b = 1 / (fingers * kDt * (1 / mass + 0.02 * 0.02 / inertia));
    ASSERT_LT(b, 100);
    const FingerForces out = tick();
    EXPECT_NEAR(out.force.x(), 0.01 * b, 1e-12);
    EXPECT_NEAR(out.damping, b, 1e-9);
  }
}

/** Elastic friction and viscosity together stay in the static cone, in their own direction; none where it is full. */
TEST_F(SoftFingerTest, ThePadsViscosityKeepsToTheCone) {
  SetFinger order = usual();
  order.damping = 10;
  finger.set(order);
  motion.body = Mobility::free(10, Mat3::Identity());
  contact.velocity = contact.at_hip = Vec3{0, 0.5, 0};  // 5 N.
  press(2, {1.2e-3, 0, 0});                             // 1.2 N of the 1.6 that friction bears.
  const Vec3 elastic(1.2, 0, 0), all = elastic + Vec3(0, 5, 0);
  FingerForces out = tick();
  EXPECT_LT((out.force + elastic - 1.6 * all.normalized()).norm(), 1e-12);
  press(2, {1.7e-3, 0, 0});
  EXPECT_TRUE(tick().force.isZero(0));
  contact.damping = -1;  // What the material's damping takes off the load, friction has not.
  press(2, {0, 0, 0});
  EXPECT_NEAR(tick().force.y(), 0.8, 1e-12);
}

/** Springs and viscosity, force and moment: all that friction bears at once is on the ellipse or within it. */
TEST_F(SoftFingerTest, WhatIsViscousKeepsToTheEllipseToo) {
  for (const bool coupled : {true, false}) {
    SetFinger order = usual();
    order.damping = 10;
    order.flags = coupled ? 0U : 0U + kFingerUncoupled;
    finger.set(order);
    motion.body = Mobility::free(10, Mat3::Identity());
    double fullest = 0;
    for (const double lag : {0.0, 0.4, -0.9}) {  // Of static friction; the twist takes up to 0.7 of it.
      for (const double turn : {0.0, 0.3, 0.7}) {
        for (const double v : {0.05, 0.5}) {
          for (const double w : {0.0, 0.5, -50.0}) {
            finger.reset();
            press(2, {lag * 1.6e-3 * std::sqrt(1 - turn * turn), 0, 0});
            motion.w_object = Vec3::Zero();
            contact.at_hip = Vec3::Zero();
            (void)tick();
            motion.w_object.z() = w;
            contact.at_hip = Vec3(0.3 * v, v, 0);
            const FingerForces out = tick(-turn * bears(kFloorStill) / 0.1);
            const double x = (kFloorStiffness * contact.pull.head<2>() + out.force.head<2>()).norm() / 1.6;
            const double y = out.moment / bears(kFloorStill), all = x * x + y * y;
            if (coupled) {
              EXPECT_LT(all, 1 + 1e-9) << lag << ' ' << turn << ' ' << v << ' ' << w;
            }
            fullest = std::max(fullest, all);
          }
        }
      }
    }
    EXPECT_NEAR(fullest, coupled ? 1 : 2, 1e-6);
  }
}

/** One wave for each millimetre, 250 a second at most; so many newtons for each m/s, 1 N at most; along z. */
TEST_F(SoftFingerTest, TheCueTellsOfEverySlip) {
  SetFinger order = usual();
  order.cue = 2;
  finger.set(order);
  (void)tick();
  double phase = 0;
  const auto expect = [&](double speed, const FingerForces& out) {
    phase += 2 * M_PI * kDt * std::min(speed / 1e-3, 250.0);
    EXPECT_NEAR(out.cue.z(), std::min(2 * speed, 1.0) * std::sin(phase), 1e-9) << speed;
    EXPECT_EQ(out.cue.head<2>().norm(), 0);
  };
  motion.hand.v = {0.4, -0.1, 0.2};
  const auto move = [&](const Vec3& v) { contact.velocity = contact.at_hip = motion.hand.v + v; };
  move({0.03, 0.04, 0.7});
  expect(0, tick());
  motion.w_object.z() = 3;
  expect(0, tick());  // What sticks does not slip, however it turns.
  motion.w_object.z() = 0;
  contact.slip = true;
  for (int i = 0; i < 20; ++i) expect(0.05, tick());
  move({0.2, 0, 0});
  for (int i = 0; i < 20; ++i) expect(0.2, tick());
  move({0, 3, 0});
  for (int i = 0; i < 20; ++i) expect(3, tick());
  move({0.03, 0.04, 0.7});
  motion.w_object.z() = -20;
  for (int i = 1; i < 20; ++i) expect(std::hypot(0.05, 20 * FingertipConstants::kArm), tick(i * 0.5));
  contact.slip = false;
  ASSERT_TRUE(finger.turning());
  for (int i = 20; i < 40; ++i) expect(20 * FingertipConstants::kArm, tick(i * 0.5));
  order.cue = 0;
  finger.set(order);
  EXPECT_TRUE(tick(21).cue.isZero(0));
}

}  // namespace
}  // namespace hapticd
