#include "rt/body/coupling.h"

#include <gtest/gtest.h>

#include <random>

#include "rt/base/rotation.h"
#include "rt/body/constraint_response.h"
#include "rt/body/direct.h"
#include "rt/body/impulse_response.h"
#include "rt/body/penalty_response.h"
#include "rt/body/tool.h"
#include "tests/support/random.h"

namespace hapticd {
namespace {

DeviceInfo desktop() {
  DeviceInfo info;
  info.viscous_friction = 0.5;
  info.max_stiffness = 4000;
  info.max_angular_stiffness = 10;
  info.actuated_rotation = true;
  return info;
}

TEST(CouplingGains, OuterSpringKeepsColgatesCondition) {
  for (const double mass : {0.02, 0.1, 0.5, 2.0}) {
    for (const double rate : {1000.0, 4000.0}) {
      for (const double latency : {0.0, 0.25e-3, 1e-3}) {
        DeviceInfo info = desktop();
        info.latency_s = latency;
        const CouplingGains g = chooseGains(info, {mass, 1e-4, 1 / rate});
        EXPECT_LE(g.outer * (0.5 / rate + latency), 0.5 * (1 + 1e-12));
        EXPECT_GT(g.outer, 0);
        EXPECT_GT(g.damping, 0);
        EXPECT_LE(g.angular_outer, 5);
      }
    }
  }
  EXPECT_EQ(chooseGains(desktop(), {0.1, 1e-4, 1e-3, 1e9}).outer, 4000) << "the device's limit binds whatever is asked";
}

/** Damping of the swing of a free tool about a hand that stands still, from the peaks of its motion. */
double logarithmicDecrement(const CouplingGains& gains, double mass, double dt) {
  ToolSetup setup;
  setup.mass = MassProperties::ofBall(mass, 0.02);
  setup.gains = gains;
  Tool tool(setup);
  tool.reset(Pose{});
  tool.setTwist({{0.1, 0, 0}, Vec3::Zero()});
  ConstraintResponse response;
  ToolStep step;
  double last = 0, before = 0, first_peak = 0, second_peak = 0;
  for (int i = 0; i < 40000 && second_peak == 0; ++i) {
    tool.step(Pose{}, {}, dt, response, step);
    const double x = tool.body().com().x();
    if (last > before && last > x && last > 0) (first_peak == 0 ? first_peak : second_peak) = last;
    before = last;
    last = x;
  }
  return second_peak > 0 ? std::log(first_peak / second_peak) : 100;
}

TEST(CouplingGains, DampingIsNearTheBestForEveryMass) {
  for (const double mass : {0.02, 0.2, 2.0}) {
    const CouplingGains g = chooseGains(desktop(), {mass, 1e-4, 0.25e-3});
    CouplingGains less = g, more = g;
    less.damping *= 0.4;
    more.damping *= 2.5;
    const double best = logarithmicDecrement(g, mass, 0.25e-3);
    EXPECT_GT(best, 0.9) << "each swing is less than half the last";
    EXPECT_GT(best, logarithmicDecrement(less, mass, 0.25e-3));
    EXPECT_GT(best, logarithmicDecrement(more, mass, 0.25e-3));
  }
}

TEST(Coupling, HoldsAtItsStiffnessInTheEndAndAtItsPointOfGrip) {
  ToolSetup setup;
  setup.mass = MassProperties::ofBox(0.2, {0.02, 0.02, 0.1});
  setup.gains = chooseGains(desktop(), {0.2, 1e-4, 1e-3});
  setup.grip_O = Vec3(0, 0, 0.05);
  setup.weight = Vec3(0, 0, -0.2 * 9.81);
  Tool tool(setup);
  tool.reset(Pose{});
  ConstraintResponse response;
  ToolStep step;
  for (int i = 0; i < 5000; ++i) tool.step(Pose{}, {}, 1e-3, response, step);
  const double k = setup.gains.outer * setup.gains.stiffness / (setup.gains.outer + setup.gains.stiffness);
  EXPECT_NEAR(step.on_device.force.z(), -0.2 * 9.81, 1e-6) << "the hand carries the weight";
  EXPECT_NEAR((tool.body().pose() * setup.grip_O).z(), -0.2 * 9.81 / k, 1e-8);
  // The grip is above the centre of mass: no torque to the hand. (R x_c) x F is not the hand's.
  EXPECT_LT(step.on_device.torque.norm(), 1e-9);

  // Held at its middle, but pushed 3 cm to the side: the hand feels the torque, at the force's lever.
  setup.grip_O.setZero();
  setup.weight = Vec3(0, 0, -1);
  setup.mass.com_O = Vec3(0.03, 0, 0);
  Tool off(setup);
  off.reset(Pose{});
  for (int i = 0; i < 5000; ++i) off.step(Pose{}, {}, 1e-3, response, step);
  const double lever = (off.body().com() - off.body().pose().p).x();
  EXPECT_NEAR(step.on_device.torque.y(), lever * 1, 1e-6);
}

/** The worst a hand can do in random and in spiteful ways: what the world gives back is what the proof allows. */
TEST(Coupling, NeverGivesMoreThanHalfKTimesTheSquareOfEachStep) {
  std::mt19937_64 dice(seedOf(3));
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 40; ++round) {
    const double mass = 0.02 * std::pow(100, (uniform(dice) + 1) / 2);
    const double dt = round % 2 == 0 ? 1e-3 : 0.25e-3;
    ToolSetup setup;
    setup.mass = MassProperties::ofBox(mass, {0.02, 0.03, 0.08});
    setup.gains = chooseGains(desktop(), {mass, setup.mass.inertia_O.trace() / 3, dt});
    setup.grip_O = Vec3(0.005, 0, 0.03);
    Tool tool(setup);
    Pose hand;
    tool.reset(hand);
    ImpulseResponse impulse;
    ConstraintResponse constraint;
    PenaltyResponse penalty;
    Response* responses[] = {&impulse, &constraint, &penalty};
    Response& response = *responses[round % 3];
    ToolStep step;
    double given = 0, allowed = 0;
    Vec3 velocity = Vec3::Zero(), turning = Vec3::Zero();
    for (int i = 0; i < 4000; ++i) {
      // Pushed along the force half of the time: that is how one gets energy out.
      const Vec3 kick(uniform(dice), uniform(dice), uniform(dice));
      velocity = 0.9 * velocity + 0.05 * kick;
      turning = 0.9 * turning + 0.5 * Vec3(uniform(dice), uniform(dice), uniform(dice));
      if (i % 100 < 50 && step.on_device.force.norm() > 0) velocity = 0.2 * step.on_device.force.normalized();
      const Vec3 dx = dt * velocity;
      const Vec3 turn = dt * turning;
      given += step.on_device.force.dot(dx) + step.on_device.torque.dot(turn);
      allowed += 0.5 * (setup.gains.outer * dx.squaredNorm() + setup.gains.angular_outer * turn.squaredNorm());
      hand.p += dx;
      hand.q = (fromRotationVector(turn) * hand.q).normalized();

      const Pose X = tool.body().pose();
      Touch floor[2];
      for (int k = 0; k < 2; ++k) {
        const Vec3 p = X * Vec3(0, 0, k == 0 ? -0.04 : 0.04);
        floor[k].r_a = p - tool.body().com();
        floor[k].gap = p.z() + 0.03;
        floor[k].friction = 0.5;
        floor[k].key = static_cast<std::uint64_t>(k) + 1;
      }
      tool.step(hand, floor, dt, response, step);
      ASSERT_LE(given + tool.energy() + tool.reserve(), allowed * 1.01 + 1e-12) << response.name() << " tick " << i;
    }
    EXPECT_GT(allowed, 0);
  }
}

/** A tool that hardly turns, and a hand that goes round and round: at each half turn the short way back is another. */
TEST(Coupling, GivesNothingAwayWhereTheHandTurnsPastHalfATurn) {
  ToolSetup setup;
  setup.mass = MassProperties::ofBox(0.1, {0.02, 0.03, 0.08});
  setup.mass.inertia_O *= 1e4;
  const CouplingGains soft{500, 2000, 5, 0.35, 0.08, 1e-4};
  for (const CouplingGains& gains : {soft, chooseGains(desktop(), {0.1, 1e-4, 1e-3})}) {
    setup.gains = gains;
    Random random(seedOf(5));
    Tool tool(setup);
    Pose hand;
    tool.reset(hand);
    ConstraintResponse response;
    ToolStep step;
    double given = 0, allowed = 0;
    int past = 0;
    Vec3 last_torque = Vec3::Zero();
    for (int i = 0; i < 3000; ++i) {
      const Vec3 turn = Vec3(0.006, 0.003, -0.004) + random.vector(1e-3);
      given += step.on_device.torque.dot(turn);
      allowed += 0.5 * gains.angular_outer * turn.squaredNorm();
      hand.q = (fromRotationVector(turn) * hand.q).normalized();
      tool.step(hand, {}, 1e-3, response, step);
      // The force is late by half a step, in which half a turn away springs stretch by up to pi / 2 for each radian.
      ASSERT_LE(given + tool.energy() + tool.reserve(), allowed * 2.47 + 1e-12) << "tick " << i;
      past += step.on_device.torque.dot(last_torque) < 0 && last_torque.norm() > 0.5 * gains.angular_outer ? 1 : 0;
      last_torque = step.on_device.torque;
    }
    EXPECT_GE(past, 2) << "it went round";
  }
}

TEST(DirectRendering, PushesByDepthAtTheDevicePose) {
  Touch touches[2];
  touches[0].r_a = Vec3(0.02, 0, 0);
  touches[0].gap = -0.001;
  touches[1].gap = 0.001;
  const DirectGains gains{.stiffness = 800, .damping = 2};
  const Wrench still = directWrench(touches, Twist{}, Twist{}, gains);
  EXPECT_NEAR(still.force.z(), 0.8, 1e-12);
  EXPECT_NEAR(still.torque.y(), -0.02 * 0.8, 1e-12);
  // Damping works against the approach, takes from the push on the way out, and never pulls.
  EXPECT_NEAR(directWrench(touches, {{0, 0, -0.1}, Vec3::Zero()}, Twist{}, gains).force.z(), 1.0, 1e-12);
  EXPECT_EQ(directWrench(touches, {{0, 0, 10}, Vec3::Zero()}, Twist{}, gains).force.z(), 0);
}

}  // namespace
}  // namespace hapticd
