// A tool that is rendered directly: how it shares its push, what it weighs, when it touches.
#include <gtest/gtest.h>

#include <memory>

#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kFloor;
using test::kWall;
using House = test::ToolHouse;

AttachTool directly(const House& house, std::uint32_t flags = 0) {
  AttachTool tool = house.tool();
  tool.flags = kToolDirect | flags;
  return tool;
}

TEST(DirectTool, WhatIsNearAndNotTouchedTakesNothingOfThePush) {
  const auto stiffness = [](bool beside) {
    House house;
    house.reshape(ShapeKind::kSphere, {0.01, 0, 0});
    // Its face is a millimetre beside the ball.
    if (beside)
      house.send(CommandKind::kAddObject, test::object(kWall, ShapeKind::kBox, {0.01, 0.05, 0.05}, {0.021, 0, 0.03}));
    house.hold(directly(house));
    house.aim({0, 0, -0.005});
    house.run(1000);
    EXPECT_EQ(house.out().contact.object, kFloor);
    const double depth = 0.01 - house.servo->lastInput().device[0].p.z();
    EXPECT_GT(depth, 1e-3);
    return house.out().command.force.z() / depth;
  };
  EXPECT_NEAR(stiffness(true) / stiffness(false), 1, 0.01);
}

TEST(DirectTool, ItsWeightPullsAtItsCentreOfMass) {
  House house;
  house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
  AttachTool tool = directly(house, kToolWeighs);
  tool.com[0] = 0.02;
  house.hold(tool);
  house.run(300);
  const ToolStep& step = house.servo->cycle().tool(0).last();
  const double weight = 9.81 * tool.mass;
  EXPECT_LT((step.on_device.force - Vec3(0, 0, -weight)).norm(), 1e-9);
  EXPECT_LT((step.on_device.torque - Vec3(0, 0.02 * weight, 0)).norm(), 1e-4 * weight) << "about the grip";
}

/** Clearly off is farther than touched: a tool at rest would touch again and again. */
TEST(DirectTool, ATouchBeginsNearerThanItEnds) {
  House house;
  house.hold(directly(house));
  house.aim({0, 0, 0});
  house.run(1000);
  ASSERT_EQ(house.out().contact.object, kFloor);
  const std::unique_ptr<Cycle> cycle = test::expectTheSameForces(house);
  CycleInput input = house.inputs.back().whole();
  input.command_count = 0;
  const auto output = std::make_unique<CycleOutput>();
  const auto touches = [&](double gap) {
    ++input.tick;
    input.now_ns += test::kPeriodNs;
    input.device[0].t_ns = input.now_ns;
    input.device[0].p = Vec3(0, 0, 0.005 + gap);
    input.device[0].q = Quat::Identity();
    cycle->step(input, *output);
    return output->device[0].contact.object == kFloor;
  };
  EXPECT_TRUE(touches(-1e-4));
  EXPECT_TRUE(touches(5e-5)) << "not clearly off";
  EXPECT_FALSE(touches(2e-4));
  EXPECT_FALSE(touches(5e-5)) << "nor on";
  EXPECT_TRUE(touches(0));
}

}  // namespace
}  // namespace hapticd
