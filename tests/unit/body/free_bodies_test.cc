// Objects that move freely, through the whole cycle: pushed, dropped, carried off, and refused.
#include "rt/cycle/free_bodies.h"

#include <gtest/gtest.h>

#include <cmath>

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
using test::kTool;
using test::object;
using test::seen;
using House = test::ToolHouse;

TEST(FreeBodies, AToolPushesOneAwayAndTheSceneFollows) {
  House house;
  house.hold();
  addBall(house, kRolled, {-0.06, 0, 0.04}, 0.3, 0.5);
  for (int i = 0; i < 700; ++i) {
    house.aim({-0.1e-3 * i, 0, 0.04});
    house.run(1);
  }
  EXPECT_LT(seen(house, kRolled).X_WO.p.x(), -0.09) << "it has been pushed along";
  EXPECT_GT(house.servo->cycle().tool(0).last().on_device.force.x(), -0.5);
  double strongest = 0;
  for (const DeviceCommand& c : house.sent) strongest = std::max(strongest, c.force.x());
  EXPECT_GT(strongest, 0.1) << "and felt";
  EXPECT_GT(seen(house, kRolled).client_edits[SceneObject::kPlace], 0u)
      << "so that control and other groups take over where it is";
  EXPECT_LT(seen(house, kRolled).V_WO.v.x(), -0.02);
  EXPECT_EQ(house.told(ServoEventKind::kTouch), 1);
  EXPECT_GT(house.out().guard.energy, -1e-3);
}

/** What one that falls brings to a tool that is rendered directly is its own, and no debt of the wall's. */
TEST(FreeBodies, OneThatFallsOnADirectToolIsChargedWithWhatItBrings) {
  House house;
  AttachTool tool = house.tool();
  tool.flags |= kToolDirect;
  house.hold(tool);
  house.run(500);
  addBall(house, kRolled, {0, 0, 0.12}, 0.1);
  gravity(house, 9.81);
  double least = 0, strongest = 0;
  for (int i = 0; i < 1000; ++i) {
    house.run(1);
    least = std::min(least, house.out().guard.energy);
    strongest = std::max(strongest, house.sent.back().force.norm());
  }
  EXPECT_GT(strongest, 5);
  EXPECT_GT(least, -1e-3);
}

TEST(FreeBodies, EnergyNeverGrowsWhileTheyTumbleAlone) {
  House house;
  gravity(house, 9.81);
  house.send(CommandKind::kAddObject, object(kRolled, ShapeKind::kBox, {0.02, 0.01, 0.03}, {0.1, 0, 0.1}));
  SetBody box = body(kRolled, 0.2);
  for (double& i : box.inertia) i *= 3;
  box.inertia[2] *= 0.5;
  house.send(CommandKind::kSetBody, box);
  house.run(5);
  const Pose X{{0.1, 0, 0.1}, Quat::Identity()};
  house.send(CommandKind::kObjectPose, poseMessage(kRolled, X, {{0.2, 0, 0}, {11, 7, 0}}));
  house.run(3);
  const auto energy = [&] {
    const FreeBody& b = house.servo->cycle().bodies().body(0);
    return b.body.kineticEnergy() + b.reserve + 0.2 * 9.81 * b.body.com().z();
  };
  double last = energy();
  ASSERT_GT(last, 0.19);
  for (int i = 0; i < 4000; ++i) {
    house.run(1);
    ASSERT_LE(energy(), last + 1e-12) << i;
    last = energy();
  }
  EXPECT_LT(last, 0.2 * 9.81 * 0.032) << "it lies";
  EXPECT_TRUE(house.servo->cycle().bodies().body(0).asleep());
}

/** A brick pressed on the floor by the tool is held by both at once: it neither sinks, creeps nor buzzes. */
TEST(FreeBodies, OnePressedOnTheFloorStaysAndThePressIsFelt) {
  for (const double mass : {0.02, 20.0}) {
    House house;
    gravity(house, 9.81);
    house.send(CommandKind::kAddObject, object(kRolled, ShapeKind::kBox, {0.03, 0.03, 0.01}, {0, 0, 0.01}));
    SetBody brick = body(kRolled, mass);
    brick.inertia[2] *= 2;
    house.send(CommandKind::kSetBody, brick);
    house.run(5);
    house.hold();
    house.aim({0.005, 0, 0.01}, Vec3(0.1, 0.05, 0));
    house.run(2000);
    EXPECT_NEAR(seen(house, kRolled).X_WO.p.z(), 0.01, 3e-5) << mass;
    const double force = house.out().command.force.z();
    EXPECT_GT(force, 1);
    const Vec3 lies = seen(house, kRolled).X_WO.p, hand = house.device.body().position();
    double most = 0;
    for (int i = 0; i < 2000; ++i) {
      house.run(1);
      most = std::max(most, std::abs(house.out().command.force.z() - force));
    }
    EXPECT_LT((seen(house, kRolled).X_WO.p - lies).norm(), 1e-5) << mass;
    EXPECT_LT((house.device.body().position() - hand).norm(), 1e-5) << mass;
    EXPECT_LT(most, 0.02 * force) << mass;
  }
}

/** Books of hand, tool, brick and gravity together, while the tool plays football with it. */
TEST(FreeBodies, NoTickOfToolAndBodiesCreatesEnergy) {
  House house;
  gravity(house, 9.81);
  house.hold();
  addBall(house, kRolled, {-0.04, 0, 0.03}, 0.15, 0.2);
  addBall(house, kOther, {0.05, 0.01, 0.03}, 0.4, 0.2);
  const Cycle& cycle = house.servo->cycle();
  const CouplingGains& g = cycle.tool(0).tool().setup().gains;
  const auto held = [&] {
    double sum = cycle.tool(0).tool().energy() + cycle.tool(0).tool().reserve();
    for (std::uint8_t k = 0; k < 2; ++k) {
      const FreeBody& b = cycle.bodies().body(k);
      sum += b.body.kineticEnergy() + b.reserve + b.body.mass() * 9.81 * b.body.com().z();
    }
    return sum;
  };
  Pose last;
  Wrench sent;
  double most = -1;
  int together = 0;
  for (int i = 0; i < 5000; ++i) {
    const double t = i * 1e-3;
    house.aim({0.05 * std::sin(9 * t), 0.02 * std::sin(4 * t), 0.02 + 0.015 * std::sin(13 * t)},
              Vec3(0.5 * std::sin(11 * t), 0, std::sin(3 * t)));
    const double had = held();
    house.run(1);
    const DeviceSample& sample = house.servo->lastInput().device[0];
    const Vec3 dx = sample.p - last.p;
    const Vec3 turn = rotationVector(sample.q * last.q.conjugate());
    const double given = -sent.force.dot(dx) - sent.torque.dot(turn);
    const double leak = 0.5 * (g.outer * dx.squaredNorm() + g.angular_outer * turn.squaredNorm());
    if (i > 0) most = std::max(most, held() - had - given - 1.01 * leak);
    last = {sample.p, sample.q};
    sent = cycle.tool(0).last().on_device;
    together += cycle.bodies().joint().movers() > 1 ? 1 : 0;
  }
  EXPECT_LE(most, 1e-9);
  EXPECT_GT(together, 500);
}

/** A ball of half the size on the right of a body, 50 mm away, as a part of it. */
void addPart(House& house, std::uint32_t of) {
  AddObject part = object(kOther, ShapeKind::kSphere, {kBallRadius / 2, 0, 0}, {0.05, 0, 0});
  part.parent = of;
  house.send(CommandKind::kAddObject, part);
}

/** By itself, or by a part of it. */
TEST(FreeBodies, AHandOfThreeAxesPushesOneWithTheForceItFeels) {
  for (const bool part : {false, true}) {
    House house("sim://default");
    house.aim({0, 0, 0.06});
    house.run(1000);
    house.send(CommandKind::kArm, DeviceRef{0});
    house.run(50);
    addBall(house, kRolled, part ? Vec3(-0.09, 0.002, 0.06) : Vec3(-0.04, 0.005, 0.06), 0.5);
    if (part) addPart(house, kRolled);
    Vec3 impulse = Vec3::Zero();
    for (int i = 0; i < 600; ++i) {
      house.aim({-0.1e-3 * i, 0, 0.06});
      house.run(1);
      const SurfaceContact& c = house.out().contact;
      if (c.object == (part ? kOther : kRolled)) impulse -= 1e-3 * c.force;
      ASSERT_LT((0.5 * house.servo->cycle().bodies().body(0).body.twist().v - impulse).norm(), 1e-10) << i;
    }
    EXPECT_LT(impulse.x(), -0.01) << "it has been pushed";
    EXPECT_LT(seen(house, kRolled).X_WO.p.x(), part ? -0.1 : -0.05);
  }
}

TEST(FreeBodies, AToolThatPushesAPartPushesTheWhole) {
  double gone[2];
  for (const bool part : {false, true}) {
    House house;
    house.hold();
    addBall(house, kRolled, {part ? -0.1 : -0.06, 0, 0.04}, 0.3, 0.5);
    if (part) addPart(house, kRolled);
    const double begun = seen(house, kRolled).X_WO.p.x();
    for (int i = 0; i < 700; ++i) {
      house.aim({-0.1e-3 * i, 0, 0.04});
      house.run(1);
    }
    gone[part ? 1 : 0] = seen(house, kRolled).X_WO.p.x() - begun;
    EXPECT_GT(house.servo->cycle().tool(0).last().on_device.force.x(), -0.5);
    EXPECT_EQ(house.told(ServoEventKind::kTouch), 1);
    EXPECT_GT(house.out().guard.energy, -1e-3);
  }
  EXPECT_LT(gone[0], -0.03);
  EXPECT_NEAR(gone[1], gone[0], 3e-3);
}

/** What lies on a part of a body that lies still does so, too; and goes along with it. */
TEST(FreeBodies, OneLiesOnAPartOfAnother) {
  House house;
  addBall(house, kRolled, {0.3, 0, kBallRadius}, 0.5);
  AddObject tray = object(makeObjectId(12, 1), ShapeKind::kBox, {0.05, 0.05, 0.005}, {0.1, 0, 0.02});
  tray.parent = kRolled;
  house.send(CommandKind::kAddObject, tray);
  addBall(house, kOther, {0.4, 0, kBallRadius + 0.03 + kBallRadius}, 0.001);
  gravity(house, 9.81);
  house.run(100);
  EXPECT_NEAR(seen(house, kOther).X_WO.p.z() - seen(house, tray.object).X_WO.p.z(), 0.005 + kBallRadius, 2e-3);
  EXPECT_GT(house.servo->cycle().bodies().body(0).body.twist().w.y(), 0) << "and its weight tips it";
}

/** In the groove between two balls that rub and damp: both together get what the hand feels. */
TEST(FreeBodies, AHandBetweenTwoPushesBothWithTheForceItFeels) {
  House house("sim://default");
  house.aim({0, 0, 0.06});
  house.run(1000);
  house.send(CommandKind::kDeviceRadius, DeviceRadius{0, 0, 0.003});
  house.send(CommandKind::kArm, DeviceRef{0});
  house.run(50);
  const Vec3 aside(0, kBallRadius + 0.05e-3, 0), at(-0.04, 0, 0.06);
  addBall(house, kRolled, at - aside, 0.5);
  addBall(house, kOther, at + aside, 0.8);
  for (const std::uint32_t id : {kRolled, kOther}) {
    house.send(CommandKind::kObjectMaterial, hd_object_material{id, 0, {1000, 2, 0.4, 0.3}});
  }
  house.run(10);
  Vec3 impulse = Vec3::Zero();
  int both = 0, rubbed = 0;
  for (int i = 0; i < 600; ++i) {
    house.aim({-0.1e-3 * i, 0.002e-3 * i, 0.06 + 0.02e-3 * i});
    house.run(1);
    const SurfaceContact& c = house.out().contact;
    if (c.object != 0) impulse -= 1e-3 * c.force;
    both += c.parts > 1;
    Vec3 shared = c.force;  // Friction and damping.
    for (std::uint32_t part = 0; part < c.parts; ++part) shared -= c.part[part].force;
    rubbed += c.parts > 1 && shared.norm() > 1e-3;
    const auto& bodies = house.servo->cycle().bodies();
    const Vec3 momentum = 0.5 * bodies.body(0).body.twist().v + 0.8 * bodies.body(1).body.twist().v;
    ASSERT_LT((momentum - impulse).norm(), 1e-9) << i;
  }
  EXPECT_GT(both, 20);
  EXPECT_GT(rubbed, 20);
  EXPECT_LT(impulse.x(), -0.01) << "they have been pushed";
}

/** The floor is touched first, and presses, too: the box feels what the hand feels of the box, and no more. */
TEST(FreeBodies, AHandThatSlidesOnTheFloorPushesWhatStandsInItsWay) {
  for (const double stiffness : {1000.0, 200.0}) {
    House house("sim://default");
    house.aim({0, 0, 0.02});
    house.run(1000);
    house.send(CommandKind::kArm, DeviceRef{0});
    house.run(50);
    house.send(CommandKind::kObjectMaterial, hd_object_material{kFloor, 0, {1000, 0, 0, 0}});
    constexpr double kHalf = 0.01;
    AddObject box = object(kRolled, ShapeKind::kBox, Vec3::Constant(kHalf), {-0.04, 0, kHalf});
    box.material = {stiffness, 0, 0, 0};
    house.send(CommandKind::kAddObject, box);
    SetBody moves = body(kRolled, 0.5);
    for (int i = 0; i < 3; ++i) moves.inertia[i] = 0.5 * 4 * kHalf * kHalf / 6;
    house.send(CommandKind::kSetBody, moves);
    for (int i = 0; i < 500; ++i) {
      house.aim({0, 0, 0.02 - 0.05e-3 * i});
      house.run(1);
    }
    ASSERT_NE(house.out().contact.object, 0u) << "on the floor";
    ASSERT_NE(house.out().contact.object, kRolled);
    double given = 0;
    int pushed = 0;
    for (int i = 0; i < 600; ++i) {
      house.aim({-0.1e-3 * i, 0, -0.005});
      house.run(1);
      const SurfaceContact& c = house.out().contact;
      given -= 1e-3 * c.force.x();
      pushed += c.parts > 1;
      const Vec3 momentum = 0.5 * house.servo->cycle().bodies().body(0).body.twist().v;
      ASSERT_NEAR(momentum.x(), given, 1e-9) << i;
      ASSERT_LT(std::abs(momentum.z()), 2e-3) << "the floor's push is not the box's";
    }
    EXPECT_GT(pushed, 5);
    EXPECT_LT(given, -0.001) << "momentum [N s]";
  }
}

TEST(FreeBodies, AHandTakesOneAsItsToolAndLetsItGo) {
  House house;
  SetBody box{};
  box = body(kTool, 0.1);
  house.send(CommandKind::kSetBody, box);
  house.run(20);
  house.hold();
  house.run(500);
  EXPECT_LT((house.place().p - house.device.body().position()).norm(), 1e-4) << "in the hand it is the hand's";
  gravity(house, 9.81);
  house.run(300);
  EXPECT_GT(seen(house, kTool).X_WO.p.z(), 0.03);
  house.send(CommandKind::kDetachTool, DeviceRef{0});
  house.run(1500);
  EXPECT_NEAR(seen(house, kTool).X_WO.p.z(), 0.005, 3e-5) << "let go it falls, and lies on its face";
}

TEST(FreeBodies, WhatAHandLetsGoFliesOnAsTheHandMovedIt) {
  House house;
  SetBody box = body(kTool, 0.1);
  box.com[0] = 0.02;  // Beside the frame: what turns moves it.
  house.send(CommandKind::kSetBody, box);
  house.run(20);
  house.hold();
  for (int i = 0; i < 300; ++i) {
    house.aim({0.2e-3 * i - 0.03, 0, 0.06}, Vec3(0, 0, 0.005 * i));
    house.run(1);
  }
  const Pose X = seen(house, kTool).X_WO;
  const Twist V = seen(house, kTool).V_WO;
  const Vec3 v = V.v + V.w.cross(X.q * vec3(box.com));
  ASSERT_GT(V.v.norm(), 0.1);
  ASSERT_GT((v - V.v).norm(), 0.05);
  house.send(CommandKind::kDetachTool, DeviceRef{0});
  house.run(30);
  const RigidBody& freed = house.servo->cycle().bodies().body(0).body;
  EXPECT_LT((freed.twist().v - v).norm(), 0.1 * v.norm());
  EXPECT_LT((freed.twist().w - V.w).norm(), 0.1 * V.w.norm());
  EXPECT_LT((seen(house, kTool).X_WO.p - X.p).norm(), 0.03 * v.norm() + 2e-3) << "from where the hand had it";
}

TEST(FreeBodies, TheSameInputsMoveThemAlikeWithoutACollideThread) {
  House house;
  house.hold();
  gravity(house, 3);
  addBall(house, kRolled, {-0.05, 0, 0.03}, 0.2);
  for (int i = 0; i < 500; ++i) {
    house.aim({-0.1e-3 * i, 0, 0.025});
    house.run(1);
  }
  const auto cycle = test::expectTheSameForces(house);
  EXPECT_EQ(cycle->scene().find(kRolled)->X_WO.p, seen(house, kRolled).X_WO.p);
}

TEST(FreeBodies, WithoutAnswersTheyStandAndGoOnWithThem) {
  House house;
  addBall(house, kRolled, {0.1, 0, 0.5}, 0.2);
  gravity(house, 1);
  house.run(100);
  house.run(300, false);
  const double z = seen(house, kRolled).X_WO.p.z();
  house.run(200, false);
  EXPECT_EQ(seen(house, kRolled).X_WO.p.z(), z) << "what it would touch is not known";
  house.run(100);
  EXPECT_LT(seen(house, kRolled).X_WO.p.z(), z);
}

TEST(FreeBodies, OneInThePlaceOfOneThatStoodStandsToo) {
  House house;
  addBall(house, kRolled, {0.1, 0, 0.5}, 0.2);
  house.run(300, false);
  house.send(CommandKind::kSetBody, body(kRolled, 0));
  AddObject next = object(kOther, ShapeKind::kSphere, {kBallRadius, 0, 0}, {0.2, 0, 0.5});
  house.send(CommandKind::kAddObject, next);
  const Pose X{{0.2, 0, 0.5}, Quat::Identity()};
  house.send(CommandKind::kObjectPose, poseMessage(kOther, X, {{0.1, 0, 0}, Vec3::Zero()}));
  house.run(10, false);
  ASSERT_NEAR(seen(house, kOther).V_WO.v.x(), 0.1, 1e-12);
  house.send(CommandKind::kSetBody, body(kOther, 0.2));
  house.run(200, false);
  EXPECT_EQ(seen(house, kOther).V_WO.v.x(), 0) << "the scene is told that it stands";
  EXPECT_EQ(seen(house, kOther).X_WO.p, house.servo->cycle().bodies().body(0).body.pose().p);
}

TEST(FreeBodies, WhatCannotMoveIsRefused) {
  House house;
  Scene scene(house.meshes);
  for (const AddObject& add : {object(kFloor, ShapeKind::kPlane, Vec3::Zero(), Vec3::Zero()),
                               object(kTool, ShapeKind::kBox, {0.01, 0.02, 0.005}, Vec3::Zero())}) {
    ASSERT_EQ(scene.apply(makeCommand(CommandKind::kAddObject, add)), ErrorCode::kOk);
  }
  const auto code = [&](const SetBody& order) {
    const auto bodies = std::make_unique<FreeBodies>();
    return bodies->set(order, scene);
  };
  EXPECT_EQ(code(body(kTool, 0.1)), ErrorCode::kOk);
  EXPECT_EQ(code(body(kTool, 0)), ErrorCode::kOk) << "no mass: it stays";
  EXPECT_EQ(code(body(kFloor, 0.1)), ErrorCode::kInvalidArgument) << "a plane has no end";
  EXPECT_EQ(code(body(kRolled, 0.1)), ErrorCode::kNotFound);
  EXPECT_EQ(code(body(kTool, -1)), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(body(kTool, std::nan(""))), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code(body(kTool, 0.1, -1)), ErrorCode::kInvalidArgument);
  const auto bodies = std::make_unique<FreeBodies>();
  EXPECT_EQ(bodies->setGravity(SetGravity{{0, 0, std::nan("")}}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(bodies->setGravity(SetGravity{{0, 0, 101}}), ErrorCode::kInvalidArgument);
  ToolContacts contacts{};
  contacts.device = kMaxDevices + kMaxBodies;
  EXPECT_EQ(bodies->take(contacts), ErrorCode::kInvalidArgument);

  for (std::uint32_t i = 0; i < kMaxBodies; ++i) addBall(house, makeObjectId(20 + i, 1), {0.2 * i, 0, 1}, 0.1);
  const int refused = house.told(ServoEventKind::kCommandRefused);
  addBall(house, kRolled, {5, 0, 1}, 0.1);
  EXPECT_EQ(house.told(ServoEventKind::kCommandRefused), refused + 1) << "kMaxBodies is the most";
  house.send(CommandKind::kRemoveObject, ObjectRef{makeObjectId(20, 1)});
  house.run(5);
  house.send(CommandKind::kSetBody, body(kRolled, 0.1));
  house.run(5);
  EXPECT_EQ(house.told(ServoEventKind::kCommandRefused), refused + 1) << "one that has gone makes room";
}

}  // namespace
}  // namespace hapticd
