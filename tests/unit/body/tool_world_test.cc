// What a tool meets in its world: surfaces that yield, weight, a gripper, and rendering without a coupling.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kFloor;
using test::kTool;
using test::kWall;
using House = test::ToolHouse;

void soften(House& house, double stiffness) {
  house.send(CommandKind::kObjectMaterial, hd_object_material{kFloor, 0, {stiffness, 0, 0.4, 0.3}});
}

/** Presses the box on the floor: force per depth of the hand below where it would touch. */
double feltStiffness(House& house) {
  house.aim({0, 0, -0.015});
  house.run(2500);
  const double depth = 0.005 - house.device.body().position().z();
  return house.out().command.force.z() / depth;
}

TEST(ToolMaterial, WhatIsSofterThanTheCouplingIsFeltAtItsOwnStiffness) {
  House house;
  const double own = [&] {
    const AttachTool g = house.tool();
    return g.outer * g.stiffness / (g.outer + g.stiffness);
  }();
  ASSERT_GT(own, 300);
  soften(house, 200);
  house.hold();
  EXPECT_NEAR(feltStiffness(house), 200, 6);
  const double sunk = 0.005 - house.place().p.z();
  EXPECT_NEAR(sunk * (1 / (1 / 200.0 - 1 / own)), house.out().command.force.z(), 0.1)
      << "the tool sinks in by the rest";
  house.aim({0, 0, 0.03});
  house.run(800);
  soften(house, 1e5);
  EXPECT_NEAR(feltStiffness(house), own, 0.03 * own) << "what is harder is rigid";
  EXPECT_NEAR(house.place().p.z(), 0.005, 2e-5);
}

TEST(ToolMaterial, ASoftFloorGivesBackNoMoreThanItTook) {
  House house;
  soften(house, 150);
  house.hold();
  const Tool& tool = house.servo->cycle().tool(0).tool();
  const CouplingGains& g = tool.setup().gains;
  Pose last;
  Wrench sent;
  double most = -1;
  for (int i = 0; i < 4000; ++i) {
    const double t = i * 1e-3;
    house.aim({0.02 * std::sin(7 * t), 0, 0.01 - 0.02 * std::sin(13 * t)},
              Vec3(0.3 * std::sin(11 * t), 0.2 * std::sin(5 * t), 0));
    const double had = tool.energy() + tool.reserve();
    house.run(1);
    const DeviceSample& sample = house.servo->lastInput().device[0];
    const Vec3 dx = sample.p - last.p;
    const Vec3 turn = rotationVector(sample.q * last.q.conjugate());
    const double given = -sent.force.dot(dx) - sent.torque.dot(turn);
    const double leak = 0.5 * (g.outer * dx.squaredNorm() + g.angular_outer * turn.squaredNorm());
    if (i > 0) most = std::max(most, tool.energy() + tool.reserve() - had - given - 1.01 * leak);
    last = {sample.p, sample.q};
    sent = house.servo->cycle().tool(0).last().on_device;
  }
  EXPECT_LE(most, 1e-9) << "no tick creates energy";
}

TEST(ToolMaterial, WhatIsKeptForRecoveryIsLittleHoweverMuchIsLost) {
  House house;
  soften(house, 1e5);
  house.hold();
  const Tool& tool = house.servo->cycle().tool(0).tool();
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    house.aim({0, 0, 0.02 - 0.03 * std::sin(0.03 * i)});
    house.run(1);
    most = std::max(most, tool.reserve());
  }
  EXPECT_EQ(most, Tool::kMostReserve) << "the bound is reached and kept";
}

TEST(ToolWeight, IsFeltByChoiceAndOnlyWithGravity) {
  for (const bool weighs : {false, true}) {
    House house;
    AttachTool wish = house.tool();
    if (weighs) wish.flags = kToolWeighs;
    house.hold(wish);
    house.run(500);
    EXPECT_LT(house.out().command.force.norm(), 0.05) << "no gravity, no weight";
    house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
    house.run(1500);
    EXPECT_NEAR(house.out().command.force.z(), weighs ? -0.1 * 9.81 : 0, 0.05) << weighs;
  }
}

TEST(ToolWeight, LoweringAHeavyToolIsChargedToGravityAndNotToTheWall) {
  House house;
  AttachTool wish = house.tool();
  wish.flags = kToolWeighs;
  wish.mass = 1;
  for (double& i : wish.inertia) i *= 10;
  house.hold(wish);
  house.aim({0, 0, 0.06});
  house.run(1500);
  house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -5}});
  house.run(1500);
  for (int i = 0; i < 1000; ++i) {
    house.aim({0, 0, 0.06 - 0.08e-3 * i});  // 0.4 J to the hand
    house.run(1);
  }
  EXPECT_EQ(house.out().guard.fault, static_cast<std::uint32_t>(HD_FAULT_NONE));
  EXPECT_GT(house.out().guard.energy, -0.01);
}

TEST(ToolDirect, PushesByOverlapWithoutAToolThatLags) {
  House house;
  AttachTool wish = house.tool();
  wish.flags = kToolDirect;
  house.hold(wish);
  house.aim({0, 0, -0.01});
  house.run(1500);
  EXPECT_LT((house.place().p - house.servo->lastInput().device[0].p).norm(), 1e-12) << "it is where the hand is";
  const double depth = 0.005 - house.servo->lastInput().device[0].p.z();
  const double k = wish.outer * wish.stiffness / (wish.outer + wish.stiffness);
  ASSERT_GT(depth, 1e-3);
  EXPECT_NEAR(house.out().command.force.z(), std::min(k, 1000.0) * depth, 0.03 * k * depth);
  EXPECT_EQ(house.out().contact.object, kFloor);
}

TEST(Gripper, OpensWhereItIsClosedFurtherThanWhatItHoldsWithinItsLimit) {
  House house("sim://default?dof=6&gripper=1&gripper_angle=0.4");
  house.hold();
  const auto pinch = [&](double angle) {
    house.device.setIntent({{0, 0, 0.04}, Quat::Identity(), angle});
    house.run(800);
  };
  house.send(CommandKind::kSetGrip, SetGrip{0, 0, 5, 0.2});
  pinch(0.3);
  EXPECT_EQ(house.out().command.gripper_force, 0) << "open beyond the width it is free";
  pinch(0.1);
  const double angle = house.servo->lastInput().device[0].gripper_rad;
  ASSERT_LT(angle, 0.2);
  EXPECT_NEAR(house.out().command.gripper_force, 5 * (0.2 - angle), 1e-3);
  house.send(CommandKind::kSetGrip, SetGrip{0, 0, 500, 0.2});
  pinch(0.0);
  EXPECT_LE(house.out().command.gripper_force, 1.0) << "the guard's own limit for it";
  double most = 0;
  for (const DeviceCommand& c : house.sent) most = std::max(most, std::abs(c.gripper_force));
  EXPECT_LE(most, 1.0);
  EXPECT_GT(most, 0.9) << "and a test must reach it";
  const std::size_t refused = static_cast<std::size_t>(house.told(ServoEventKind::kCommandRefused));
  house.send(CommandKind::kSetGrip, SetGrip{0, 0, std::nan(""), 0.2});
  house.run(2);
  EXPECT_EQ(house.told(ServoEventKind::kCommandRefused), static_cast<int>(refused) + 1);
}

}  // namespace
}  // namespace hapticd
