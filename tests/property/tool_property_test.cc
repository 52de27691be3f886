// A tool in a hand that does anything, among touches that are anything: its books balance, whatever the response says.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "rt/body/constraint_response.h"
#include "rt/body/impulse_response.h"
#include "rt/body/joint_step.h"
#include "rt/body/penalty_response.h"
#include "rt/body/tool.h"
#include "tests/support/for_seeds.h"

namespace hapticd {
namespace {

constexpr double kToolDt = 1e-3;

double between(Random& random, double low, double high) { return std::exp(random.in(std::log(low), std::log(high))); }

ToolSetup randomTool(Random& random) {
  ToolSetup setup;
  const double size = between(random, 0.003, 0.3);
  setup.mass = MassProperties::ofBox(between(random, 1e-3, 10),
                                     size * Vec3(random.in(0.05, 1), random.in(0.05, 1), random.in(0.05, 1)));
  setup.mass.com_O = random.vector(size);
  setup.grip_O = random.vector(size);
  setup.turned = random.turn();
  setup.gains = {between(random, 10, 5000), between(random, 10, 5000), random.once(4) ? 0 : between(random, 0.01, 50),
                 between(random, 1e-3, 10), between(random, 1e-3, 10), random.once(4) ? 0 : between(random, 1e-5, 0.1)};
  if (random.once(3)) setup.weight = -9.81 * setup.mass.mass * Vec3::UnitZ();
  return setup;
}

Touch randomTouch(Random& random, std::uint64_t key) {
  Touch touch;
  touch.r_a = random.vector(0.1);
  touch.n = random.once(3) ? Vec3(Vec3::UnitZ()) : Vec3(random.vector(1).normalized());
  touch.gap = random.once(3) ? random.in(0, 1e-3) : -between(random, 1e-6, 0.02);
  touch.friction = random.once(3) ? 0 : random.in(0, 3);
  touch.restitution = random.once(3) ? random.in(0, 1) : 0;
  if (random.once(4)) touch.moving = random.vector(between(random, 1e-3, 10));
  if (random.once(4)) touch.give = 1 / between(random, 50, 5000);
  touch.key = random.once(2) ? key : 0;
  return touch;
}

std::unique_ptr<Response> randomResponse(Random& random) {
  if (random.once(3)) return std::make_unique<ImpulseResponse>();
  if (random.once(2)) return std::make_unique<PenaltyResponse>();
  return std::make_unique<ConstraintResponse>();
}

TEST(ToolProperty, NeverHoldsMoreEnergyThanHandWeightAndObstaclesGave) {
  int clamped = 0, touched = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    Tool tool(randomTool(random));
    const auto response = randomResponse(random);
    Pose device = random.pose(0.1);
    tool.reset(device);
    const double reach = between(random, 1e-6, 0.02);
    const Vec3 round = random.once(2) ? random.vector(std::min(0.02, 10 * reach)) : Vec3(Vec3::Zero());
    Wrench sent;
    for (int tick = 0; tick < 300; ++tick) {
      SCOPED_TRACE(testing::Message() << "tick " << tick);
      const Vec3 step = random.vector(random.once(50) ? 0.3 : reach);
      const Vec3 turn = random.once(50) ? random.vector(2) : Vec3(round + random.vector(std::min(0.02, 10 * reach)));
      device.p += step;
      device.q = rotated(device.q, turn, 1).normalized();
      std::array<Touch, 18> touch;
      const auto count = static_cast<std::size_t>(random.once(3) ? 0 : random.below(18));
      for (std::size_t i = 0; i < count; ++i) touch[i] = randomTouch(random, 1 + i);
      // What the hand gave is in once the tool has heard where it went.
      Tool after_hand = tool;
      Tool::Kick kick;
      after_hand.kick(device, kToolDt, kick);
      const double had = after_hand.energy(), reserve = tool.reserve();
      if (turn.norm() < 0.1) {
        const double gave = -sent.force.dot(step) - sent.torque.dot(turn);
        const CouplingGains& g = tool.setup().gains;
        const double late = 0.5 * (g.outer * step.squaredNorm() + g.angular_outer * turn.squaredNorm());
        // Half a turn away the springs stretch by pi / 2 for each radian across: up to pi^2 / 4 as much is late.
        ASSERT_LE(had - tool.energy(), gave + 2.47 * late + 1e-12 * (had + 1));
      }
      const Vec3 com = tool.body().com();
      ToolStep out;
      tool.step(device, std::span(touch).first(count), kToolDt, *response, out);
      ASSERT_TRUE(isFinite(out.on_device.force) && isFinite(out.on_device.torque));
      ASSERT_TRUE(isFinite(tool.body().com()) && std::isfinite(tool.energy()));
      ASSERT_LE(tool.body().twist().v.norm(), Tool::kMostSpeed * (1 + 1e-9));
      ASSERT_GE(tool.reserve(), 0);
      const double given = out.obstacle_work.sum() + tool.setup().weight.dot(tool.body().com() - com);
      // Each joule is kept, lost for good or put by; none comes from nowhere.
      ASSERT_LE(tool.energy() + tool.reserve() - had - reserve, given + 1e-12 * (had + 1)) << response->name();
      sent = out.on_device;
      clamped += out.clamped < 1 ? 1 : 0;
      touched += out.touching > 0 ? 1 : 0;
    }
  });
  EXPECT_GT(touched, 0);
  EXPECT_GT(clamped, 0) << "else the books had nothing to do";
}

FreeBody randomBody(Random& random) {
  const double size = between(random, 0.003, 0.3);
  FreeBody body(MassProperties::ofBox(between(random, 1e-4, 10),
                                      size * Vec3(random.in(0.05, 1), random.in(0.05, 1), random.in(0.05, 1))),
                random.once(2) ? random.in(0, 5) : 0, random.once(2));
  body.body.place(random.pose(0.1));
  body.body.setTwist({random.vector(between(random, 1e-3, 3)), random.vector(between(random, 1e-2, 100))});
  return body;
}

TEST(ToolProperty, AmongFreeBodiesAllHoldTogetherNoMoreThanTheyWereGiven) {
  const Vec3 gravity(0, 0, -9.81);
  int clamped = 0, touched = 0;
  forSeeds(60, [&](unsigned seed) {
    Random random(seed);
    auto joint = std::make_unique<JointStep>();
    std::vector<Tool> tools;
    std::vector<Pose> device;
    std::vector<FreeBody> bodies;
    for (int i = random.below(3); i > 0; --i) {
      tools.emplace_back(randomTool(random));
      device.push_back(random.pose(0.1));
      tools.back().reset(device.back());
    }
    for (int i = (tools.empty() ? 1 : 0) + random.below(6); i > 0; --i) bodies.push_back(randomBody(random));
    const auto movers = static_cast<std::uint32_t>(tools.size() + bodies.size());
    const double reach = between(random, 1e-6, 0.02);
    for (int tick = 0; tick < 150; ++tick) {
      SCOPED_TRACE(testing::Message() << "tick " << tick);
      double had = 0, given = 0, holds = 0;
      joint->begin(kToolDt, gravity);
      std::array<ToolStep, 2> out;
      std::array<double, 2> tool_had{};
      for (std::size_t i = 0; i < tools.size(); ++i) {
        device[i].p += random.vector(random.once(50) ? 0.3 : reach);
        device[i].q = rotated(device[i].q, random.vector(10 * reach), 1).normalized();
        Tool after_hand = tools[i];
        Tool::Kick kick;
        after_hand.kick(device[i], kToolDt, kick);
        tool_had[i] = after_hand.energy() + tools[i].reserve();
        had += tool_had[i];
        given -= tools[i].setup().weight.dot(tools[i].body().com());
        tool_had[i] -= tools[i].setup().weight.dot(tools[i].body().com());
        (void)joint->add(tools[i], device[i], out[i]);
      }
      for (FreeBody& body : bodies) {
        had += body.body.kineticEnergy() + body.reserve;
        given -= body.weightOf(gravity).dot(body.body.com());
        (void)joint->add(body);
      }
      for (std::uint32_t k = 0, n = random.below(40u); k < n; ++k) {
        Touch touch = randomTouch(random, 1 + k);
        touch.r_b = random.vector(0.1);
        touch.moving.setZero();
        const auto a = static_cast<std::uint8_t>(random.below(movers));
        const auto b = static_cast<std::uint8_t>(random.below(movers));
        (void)joint->add(touch, a, a == b || random.once(3) ? JointStep::kFixed : b);
      }
      joint->solve();
      for (std::size_t i = 0; i < tools.size(); ++i) {
        ASSERT_TRUE(isFinite(out[i].on_device.force) && isFinite(out[i].on_device.torque));
        const double tool_holds = tools[i].energy() + tools[i].reserve();
        const double by_weight = tools[i].setup().weight.dot(tools[i].body().com());
        holds += tool_holds;
        given += by_weight;
        // Else the guard took it for the hand's: what a tool has more, it is told, bodies have brought.
        ASSERT_LE(tool_holds - by_weight - tool_had[i], out[i].obstacle_work.sum() + 1e-12 * (had + 1));
        clamped += out[i].clamped < 1 ? 1 : 0;
        touched += out[i].touching > 0 ? 1 : 0;
      }
      for (const FreeBody& body : bodies) {
        ASSERT_TRUE(isFinite(body.body.com()));
        holds += body.body.kineticEnergy() + body.reserve;
        given += body.weightOf(gravity).dot(body.body.com());
      }
      ASSERT_LE(holds - had, given + 1e-12 * (had + 1));
    }
  });
  EXPECT_GT(touched, 0);
  EXPECT_GT(clamped, 0) << "else the books had nothing to do";
}

}  // namespace
}  // namespace hapticd
