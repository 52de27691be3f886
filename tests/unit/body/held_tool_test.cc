// A tool in the hand through the whole cycle: orders in, contacts from the collide side, forces out by the guard.
#include "rt/cycle/held_tool.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kFloor;
using test::kTool;
using test::kWall;
using test::object;
using House = test::ToolHouse;

TEST(HeldTool, FollowsTheHandAndLiesOnTheFloorThatStopsIt) {
  House house;
  house.hold();
  EXPECT_LT((house.place().p - house.device.body().position()).norm(), 1e-4) << "it is where the hand is";
  EXPECT_LT(house.out().command.force.norm(), 0.05) << "and weighs nothing";

  house.aim({0, 0, -0.02});
  house.run(1500);
  EXPECT_NEAR(house.place().p.z(), 0.005, 2e-5) << "half a box above the floor";
  const AttachTool g = house.tool();
  const double k = g.outer * g.stiffness / (g.outer + g.stiffness);
  const double depth = 0.005 - house.device.body().position().z();
  ASSERT_GT(depth, 0.001);
  EXPECT_NEAR(house.out().command.force.z(), k * depth, 0.02 * k * depth + 0.02);
  const SurfaceContact& contact = house.out().contact;
  EXPECT_EQ(contact.object, kFloor);
  EXPECT_LT((contact.proxy - house.place().p).norm(), 1e-12) << "what is shown is where the tool is";
  EXPECT_NEAR(contact.depth, depth, 1e-5) << "and how far the hand has left it";
  EXPECT_NEAR(contact.point.z(), 0, 2e-5);
  EXPECT_LT((contact.normal - Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_LT((contact.smooth - Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_LT((contact.force - house.out().guard.by_source[HD_SOURCE_SURFACE]).norm(), 1e-9);
  const SceneObject* seen = house.servo->cycle().scene().find(kTool);
  ASSERT_NE(seen, nullptr);
  EXPECT_LT((seen->X_PO.p - house.place().p).norm(), 1e-9) << "the scene's object follows";

  // Turned in the hand, the box lies on an edge of its own and turns the hand back.
  house.aim({0, 0, -0.02}, Vec3(0.4, 0, 0));
  house.run(1500);
  EXPECT_LT(house.out().command.torque.x(), -1e-3);

  house.aim({0, 0, 0.05});
  house.run(1500);
  EXPECT_EQ(contact.object, 0u);
  EXPECT_EQ(contact.depth, 0);
  EXPECT_EQ(contact.point, contact.proxy) << "as of a point in free space";
  EXPECT_LT(house.out().command.force.norm(), 0.05);
  EXPECT_EQ(house.told(ServoEventKind::kTouch), 1);
  EXPECT_EQ(house.told(ServoEventKind::kUntouch), 1);
}

TEST(HeldTool, IsNotStoppedByWhatIsPartOfIt) {
  House house;
  AddObject knob = object(kWall, ShapeKind::kSphere, {0.01, 0, 0}, {0, 0, -0.008});
  knob.parent = kTool;
  house.send(CommandKind::kAddObject, knob);
  house.hold();
  house.run(300);
  EXPECT_EQ(house.out().contact.object, 0u);
  EXPECT_LT((house.place().p - house.device.body().position()).norm(), 1e-4);
}

TEST(HeldTool, ADeviceOfThreeAxesGetsTheForceAndNoTorque) {
  House house("sim://default");
  house.hold();
  house.aim({0, 0, -0.02});
  house.run(1000);
  EXPECT_GT(house.out().command.force.z(), 0.5);
  EXPECT_TRUE(house.out().command.torque.isZero(0));
}

TEST(HeldTool, AnAnswerEveryFifthTickFeelsLikeOneInEach) {
  const auto pressed = [](int every) {
    House house("sim://default?dof=6", every);
    house.hold();
    for (int i = 0; i < 1000; ++i) {
      house.aim({0.01 * std::sin(i * 0.005), 0, 0.01 - 0.03 * std::sin(i * 0.004)},
                Vec3(0.2 * std::sin(i * 0.007), 0, 0));
      house.run(1);
    }
    return house.sent;
  };
  const auto each = pressed(1);
  const auto fifth = pressed(5);
  double error = 0, size = 0;
  for (std::size_t i = 0; i < each.size(); ++i) {
    error += (each[i].force - fifth[i].force).squaredNorm();
    size += each[i].force.squaredNorm();
  }
  EXPECT_GT(size, 0);
  EXPECT_LT(std::sqrt(error / size), 0.03);
}

TEST(HeldTool, TheSameInputsGiveTheSameForcesWithoutACollideThread) {
  House house;
  house.hold();
  house.aim({0.005, 0, -0.015}, Vec3(0.1, 0.2, 0));
  house.run(600);
  test::expectTheSameForces(house);
}

TEST(HeldTool, StaleContactsFadeTheForceOut) {
  House house;
  house.hold();
  house.aim({0, 0, -0.02});
  house.run(800);
  ASSERT_GT(house.out().command.force.z(), 0.5);
  house.run(90, false);
  EXPECT_GT(house.out().command.force.z(), 0.5) << "it goes on with what it has";
  double last = house.out().command.force.norm();
  for (int i = 0; i < 80; ++i) {
    house.run(1, false);
    EXPECT_LE(house.out().command.force.norm(), last + 0.05);
    last = house.out().command.force.norm();
  }
  EXPECT_LT(last, 1e-6);
}

/** Meanwhile the coupling is stretched under the hand: what it holds comes back as slowly as it went. */
TEST(HeldTool, ContactsThatComeAgainLetTheForceRiseAsItFell) {
  House house;
  house.hold();
  house.aim({0, 0, -0.02});
  house.run(800);
  house.run(170, false);
  ASSERT_TRUE(house.out().command.force.isZero(1e-6));
  house.run(2);  // The answer of the second tick is taken in the next.
  const double whole = house.servo->cycle().tool(0).last().on_device.force.norm();
  ASSERT_GT(whole, 0.5);
  const auto asked = [&] { return house.out().guard.by_source[HD_SOURCE_SURFACE].norm(); };
  double last = asked(), most = last, lowest = 0;
  for (int i = 0; i < 200; ++i) {
    house.run(1);
    const double now = asked();
    most = std::max(most, now - last);
    lowest = std::min(lowest, house.out().guard.energy);
    last = now;
  }
  EXPECT_GT(last, 0.5);
  EXPECT_LT(most, whole / 40);
  EXPECT_GT(lowest, -1e-3) << "what comes back is charged to what was away";
}

TEST(HeldTool, AMovingWallIsFeltAndChargedToWhoMovesIt) {
  House house;
  house.send(CommandKind::kAddObject, object(kWall, ShapeKind::kBox, {0.02, 0.05, 0.05}, {-0.06, 0, 0.04}));
  house.hold();
  const Pose X{{-0.06, 0, 0.04}, Quat::Identity()};
  house.send(CommandKind::kObjectPose, poseMessage(kWall, X, {{0.1, 0, 0}, Vec3::Zero()}));
  house.run(600);  // its face has come from -4 cm to 2 cm
  EXPECT_GT(house.place().p.x(), 0.025);
  EXPECT_GT(house.out().command.force.x(), 0.5);
  EXPECT_EQ(house.out().contact.object, kWall);
  EXPECT_GT(house.servo->cycle().tool(0).last().obstacle_work.x(), 0);
  EXPECT_GT(house.out().guard.energy, -1e-3) << "the guard knows that the hand was pushed by who moves the wall";
}

TEST(HeldTool, GoesWithItsObjectAndRefusesWhatIsNoTool) {
  House house;
  house.hold();
  house.send(CommandKind::kRemoveObject, ObjectRef{kTool});
  house.run(5);
  EXPECT_FALSE(house.servo->cycle().tool(0).held());

  Scene const& scene = house.servo->cycle().scene();
  HeldTool tool;
  AttachTool wish = house.tool();
  EXPECT_EQ(tool.attach(wish, scene), ErrorCode::kNotFound);
  wish.object = kFloor;
  EXPECT_EQ(tool.attach(wish, scene), ErrorCode::kInvalidArgument) << "a plane has no end";
  EXPECT_FALSE(tool.held());
}

/** Each touch that is told has its end told before the next one, whatever ends it. */
TEST(HeldTool, TakingItUpAndLettingGoEndsWhatTouched) {
  House house;
  const auto on = [&] { return house.told(ServoEventKind::kTouch) - house.told(ServoEventKind::kUntouch); };
  house.aim({0, 0, -0.005});
  house.run(300);
  ASSERT_EQ(on(), 1) << "the empty hand stands on the floor";
  house.hold();
  house.run(300);
  ASSERT_EQ(house.out().contact.object, kFloor);
  EXPECT_EQ(on(), 1) << "now the tool does";
  house.aim({0, 0, 0.002});
  house.run(300);
  ASSERT_EQ(house.out().contact.object, kFloor);
  house.send(CommandKind::kDetachTool, DeviceRef{0});
  house.run(5);
  ASSERT_EQ(house.out().contact.object, 0u);
  EXPECT_EQ(on(), 0) << "the hand is above what its tool stood on";
  int touching = 0;
  for (const ServoEventKind kind : house.events) {
    touching += (kind == ServoEventKind::kTouch ? 1 : 0) - (kind == ServoEventKind::kUntouch ? 1 : 0);
    ASSERT_TRUE(touching == 0 || touching == 1) << "in turns";
  }
}

/** Contacts that were found with an obstacle are none of it elsewhere, nor of what stands in its slot next. */
TEST(HeldTool, WhatIsPutElsewhereUnderItDealsNoBlow) {
  enum class Goes { kElsewhere, kForAnother, kForABody };
  for (const std::uint32_t flags : {0u, std::uint32_t{kToolDirect}}) {
    for (const Goes goes : {Goes::kElsewhere, Goes::kForAnother, Goes::kForABody}) {
      House house;
      AddObject wall = object(kWall, ShapeKind::kBox, {0.05, 0.05, 0.01}, {0, 0, 0.02});
      wall.material.stiffness = 100;
      house.send(CommandKind::kAddObject, wall);
      house.aim({0, 0, 0.06});
      house.run(200);
      AttachTool tool = house.tool();
      tool.flags |= flags;
      house.hold(tool);
      house.aim({0, 0, 0.032});
      house.run(1500);
      const double pressed = house.sent.back().force.norm();
      ASSERT_GT(pressed, 0.2);
      if (goes == Goes::kElsewhere) {
        house.send(CommandKind::kObjectPose, hd_object_pose{kWall, 0, {0, 0, 0.52}, {1}, {}, {}});
      } else {
        wall.object = makeObjectId(objectSlot(kWall), 2);
        store(Vec3(0, 0, 0.6), wall.p);
        house.send(CommandKind::kRemoveObject, ObjectRef{kWall});
        house.send(CommandKind::kAddObject, wall);
      }
      if (goes == Goes::kForABody) {
        SetBody body{};
        body.object = wall.object;
        body.mass = 1;
        for (int i = 0; i < 3; ++i) body.inertia[i] = 1e-3;
        house.send(CommandKind::kSetBody, body);
      }
      double strongest = 0;
      for (int i = 0; i < 40; ++i) {
        house.run(1);
        strongest = std::max(strongest, house.sent.back().force.norm());
      }
      EXPECT_LT(strongest, pressed) << flags << ' ' << static_cast<int>(goes);
    }
  }
}

/** By its mount, while it is off: what it touched where it was says nothing of where it is. */
TEST(HeldTool, OneWhoseDeviceIsSetUpElsewhereDealsNoBlow) {
  for (const std::uint32_t flags : {0u, std::uint32_t{kToolDirect}}) {
    for (const auto& [free, taken_anew] : {std::pair(false, false), {true, false}, {true, true}}) {
      SCOPED_TRACE(testing::Message() << flags << ' ' << free << ' ' << taken_anew);
      House house;
      house.send(CommandKind::kAddObject, object(kWall, ShapeKind::kBox, {0.05, 0.05, 0.01}, {0, 0, 0.07}));
      AttachTool tool = house.tool();
      tool.flags |= flags;
      house.hold(tool);
      house.aim({0, 0, 0.057});
      house.run(500);
      ASSERT_EQ(house.out().contact.object, kWall);
      house.send(CommandKind::kDisarm, DeviceRef{0});
      house.run(4);
      ASSERT_FALSE(house.servo->cycle().deviceGuard(0).armed());
      if (free) {
        SetBody body{};
        body.object = kWall;
        body.mass = 1;
        for (int i = 0; i < 3; ++i) body.inertia[i] = 1e-3;
        house.send(CommandKind::kSetBody, body);
        house.run(5);
      }
      const auto speed = [&] { return house.servo->cycle().scene().find(kWall)->V_WO.v.norm(); };
      const auto asked = [&] { return house.out().guard.by_source[HD_SOURCE_SURFACE].norm(); };
      const double most = asked(), fastest = speed();
      // An answer is on its way, to where it was.
      house.collider.step(nullptr);
      Command late;
      ASSERT_TRUE(house.collider.answers.pop(late));
      house.send(CommandKind::kSetMount, Mount(Pose{{0, 0, 0.3}, Quat::Identity()}).order(0));
      if (taken_anew) {  // The answer is of the object that is in the hand, all the same.
        house.send(CommandKind::kDetachTool, DeviceRef{0});
        house.send(CommandKind::kAttachTool, tool);
      }
      house.run(1, false);
      ASSERT_TRUE(house.collider.answers.push(late));
      for (int i = 0; i < 40; ++i) {
        house.run(1);
        EXPECT_LE(asked(), most) << i;
        EXPECT_LE(speed(), fastest + 0.01) << i;
        EXPECT_LT((house.place().p - house.out().pose.p).norm(), 1e-3) << "it is where the hand is";
      }
    }
  }
}

TEST(HeldTool, HostileNumbersAreRefused) {
  House house;
  Scene const& scene = house.servo->cycle().scene();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change) {
    AttachTool wish = house.tool();
    change(wish);
    HeldTool tool;
    return tool.attach(wish, scene) == ErrorCode::kInvalidArgument && !tool.held();
  };
  EXPECT_FALSE(refused([](AttachTool&) {}));
  EXPECT_TRUE(refused([](AttachTool& t) { t.mass = 0; }));
  EXPECT_TRUE(refused([&](AttachTool& t) { t.outer = nan; }));
  EXPECT_TRUE(refused([](AttachTool& t) { t.damping = -1; }));
  EXPECT_TRUE(refused([](AttachTool& t) { t.inertia[0] = 1; }));
  EXPECT_TRUE(refused([&](AttachTool& t) { t.com[1] = nan; }));

  HeldTool tool;
  ASSERT_EQ(tool.attach(house.tool(), scene), ErrorCode::kOk);
  ToolContacts contacts{};
  contacts.object = kTool;
  contacts.count = 15;
  EXPECT_EQ(tool.take(contacts), ErrorCode::kInvalidArgument);
  contacts.count = 1;
  EXPECT_EQ(tool.take(contacts), ErrorCode::kInvalidArgument) << "a normal of length zero";
  contacts.point[0].n_B[2] = 1;
  EXPECT_EQ(tool.take(contacts), ErrorCode::kOk);
  contacts.point[0].p_A[0] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(tool.take(contacts), ErrorCode::kInvalidArgument);
}

TEST(HeldTool, TheQuestionTellsHowToolBodiesAndObstaclesMove) {
  House house;
  AttachTool tool = house.tool();
  tool.com[0] = 0.02;  // Beside the frame: what turns moves it.
  house.hold(tool);
  const std::uint32_t kBrick = makeObjectId(4, 1);
  house.send(CommandKind::kAddObject, test::object(kWall, ShapeKind::kSphere, {0.01, 0, 0}, {0, 0.06, 0.05}));
  house.send(CommandKind::kAddObject, test::object(kBrick, ShapeKind::kBox, {0.01, 0.01, 0.01}, {0, -0.06, 0.05}));
  house.send(CommandKind::kSetBody, SetBody{kBrick, 1, 0.2, {0.01, 0, 0}, {1e-4, 1e-4, 1e-4}, 0});
  house.run(3);
  house.send(CommandKind::kObjectPose, hd_object_pose{kWall, 0, {0, 0.06, 0.05}, {1}, {0.2F, -0.1F, 0.1F}, {0, 3, 0}});
  house.send(CommandKind::kObjectPose,
             hd_object_pose{kBrick, 0, {0, -0.06, 0.05}, {1}, {-0.1F, 0.1F, 0.2F}, {1, 0, 4}});
  house.aim({0.02, 0.01, 0.06}, Vec3(0.5, 0.3, 0.8));
  house.run(30);
  auto before = std::make_unique<CollideRequest>(), now = std::make_unique<CollideRequest>();
  ASSERT_TRUE(house.servo->cycle().ask(*before));
  house.run(1);
  ASSERT_TRUE(house.servo->cycle().ask(*now));
  const auto moved = [](const Pose& from, const Pose& to, const Twist& V, const char* what) {
    const Vec3 v = (to.p - from.p) / 1e-3, w = rotationVector(to.q * from.q.conjugate()) / 1e-3;
    EXPECT_GT(v.norm(), 0.05) << what;
    EXPECT_GT(w.norm(), 0.2) << what;
    EXPECT_LT((V.v - v).norm(), 0.03 * v.norm()) << what;
    EXPECT_LT((V.w - w).norm(), 0.03 * w.norm()) << what;
  };
  const CollideRequest::Held &a = before->held[0], &b = now->held[0];
  ASSERT_EQ(b.object, kTool);
  moved(a.X_WO, b.X_WO, b.V_WO, "the tool");
  moved(before->held[kMaxDevices].X_WO, now->held[kMaxDevices].X_WO, now->held[kMaxDevices].V_WO, "the body");
  int seen = 0;
  for (std::uint32_t k = 0; k < b.count; ++k) {
    if (b.obstacle[k].slot != objectSlot(kWall) && b.obstacle[k].slot != objectSlot(kBrick)) continue;
    ASSERT_EQ(a.obstacle[k].slot, b.obstacle[k].slot);
    moved(a.obstacle[k].X_WO, b.obstacle[k].X_WO, b.obstacle[k].V_WO, "an obstacle");
    ++seen;
  }
  EXPECT_EQ(seen, 2);
}

/** It stands on the floor, as a body does that is not felt. */
TEST(HeldTool, OneThatIsNotFeltPassesABodyThatMoves) {
  for (const bool disabled : {false, true}) {
    House house;
    house.hold();
    if (disabled) {
      house.send(CommandKind::kObjectFlags, hd_object_flags{kTool, HD_OBJECT_ENABLED, 0, 0});
    } else {
      house.send(CommandKind::kObjectMaterial, hd_object_material{kTool, 0, {}});
    }
    house.send(CommandKind::kAddObject, object(kWall, ShapeKind::kSphere, {0.02, 0, 0}, {-0.06, 0, 0.04}));
    SetBody ball{};
    ball.object = kWall;
    ball.mass = 0.3;
    for (double& i : ball.inertia) i = 0;
    for (int i = 0; i < 3; ++i) ball.inertia[i] = 5e-5;
    house.send(CommandKind::kSetBody, ball);
    for (int i = 0; i < 700; ++i) {
      house.aim({-0.1e-3 * i, 0, 0.04});
      house.run(1);
      ASSERT_EQ(house.servo->cycle().tool(0).last().touching, 0u) << i;
    }
    EXPECT_EQ(house.servo->cycle().scene().find(kWall)->X_WO.p, Vec3(-0.06, 0, 0.04));
    house.aim({-0.07, 0, -0.01});
    house.run(1000);
    EXPECT_EQ(house.out().contact.object, kFloor);
  }
}

/** Two in the hands of two, one 1 mm in the other. */
TEST(HeldTool, OneThatIsNotFeltPassesAnother) {
  constexpr std::uint32_t kLower = makeObjectId(4, 1);
  constexpr std::uint32_t kPart = makeObjectId(5, 1);
  for (const auto& [felt, as_part] : {std::pair{true, false}, {false, false}, {true, true}, {false, true}}) {
    CycleConfig config;
    config.device_count = 2;
    test::SteppedCycle hands(config);
    for (const std::uint32_t id : {kTool, kLower}) {
      hands.add(object(id, ShapeKind::kBox, {0.01, 0.02, 0.005}, {0, 0, 0}));
      AttachTool tool = test::attachBox(id, {0.02, 0.04, 0.01}, DeviceInfo{});
      tool.device = id == kTool ? 0 : 1;
      hands.put(CommandKind::kAttachTool, tool);
    }
    AddObject part = object(kPart, ShapeKind::kBox, {0.01, 0.02, 0.005}, {0, 0, 0});
    part.parent = kLower;
    hands.add(part);
    if (!felt) hands.put(CommandKind::kObjectMaterial, hd_object_material{kTool, 0, {}});
    hands.input->device[1].p.z() = -0.009;
    hands.input->device[1].fresh = true;
    for (int i = 0; i < 5; ++i) hands.at(Vec3::Zero());
    ToolContacts found{};
    found.object = kTool;
    found.count = 1;
    found.point[0] = {{0, 0, -0.005F}, {0, 0, 1}, 0.005F, objectSlot(as_part ? kPart : kLower) << 24 | 1};
    hands.answer(found);
    hands.at(Vec3::Zero());
    EXPECT_EQ(hands.cycle->tool(0).last().touching > 0, felt) << as_part;
  }
}

}  // namespace
}  // namespace hapticd
