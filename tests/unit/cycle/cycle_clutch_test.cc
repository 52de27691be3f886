// A hand that is taken off its point in the world: where the point stands, what is felt meanwhile and afterwards.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "rt/cycle/cycle_start.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kClutchFloor = makeObjectId(1, 1), kClutchBody = makeObjectId(2, 1);

/** One device above a floor of 500 N/m, armed and in the air. */
class CycleClutch : public testing::Test, protected test::SteppedCycle {
 protected:
  explicit CycleClutch(double scale = 1) : SteppedCycle(test::openConfig(10)) {
    add(test::solid(kClutchFloor, ShapeKind::kPlane, {500, 0, 0, 0}));
    if (scale != 1) put(CommandKind::kSetMount, test::mountAt({}, 0, scale));
    at({0, 0, 0.05});
    arm();
    steps(10);
  }
  void steps(int n) {
    for (int i = 0; i < n; ++i) step();
  }
  /** There at half a metre per second, and at rest; says the largest step of the force. */
  double walk(const Vec3& to) {
    double most = 0;
    Vec3 last = output->device[0].command.force;
    while (input->device[0].p != to) {
      at(input->device[0].p + clampNorm(to - input->device[0].p, 0.5e-3));
      most = std::max(most, (output->device[0].command.force - last).norm());
      last = output->device[0].command.force;
    }
    steps(20);
    return most;
  }
  void clutch(bool held, std::uint32_t button = 0) {
    put(CommandKind::kSetClutch, SetClutch{0, held ? 1u : 0u, button, 0, {}});
  }
  [[nodiscard]] const DeviceOutput& out() const { return output->device[0]; }
  [[nodiscard]] double weight() const { return cycle->clutch(0).weight(); }
};

TEST_F(CycleClutch, InTheAirThePointStandsStillAtOnceAndComesAlongWhenLetGo) {
  clutch(true);
  step();
  const Vec3 there = out().pose.p;
  EXPECT_EQ(there, Vec3(0, 0, 0.05));
  EXPECT_TRUE(cycle->clutch(0).frozen());
  walk({0.03, -0.02, -0.04});
  EXPECT_EQ(out().pose.p, there) << "the hand is in the floor, its point is not";
  EXPECT_EQ(out().velocity.v, Vec3(0, 0, 0));
  EXPECT_TRUE(out().command.force.isZero(0));
  EXPECT_TRUE(out().command.enabled);
  clutch(false);
  step();
  EXPECT_LT((out().pose.p - there).norm(), 1e-15);
  EXPECT_LT((cycle->mount(0).pose().p - Vec3(-0.03, 0.02, 0.09)).norm(), 1e-15);
  walk({0.03, -0.02, -0.091});
  EXPECT_NEAR(out().pose.p.z(), -0.001, 1e-12);
  EXPECT_NEAR(out().command.force.z(), 0.5, 1e-9) << "one millimetre deep where the point is now";
}

/** Control does not know yet where the clutch has brought the device: of an order for the scale only that is taken. */
TEST_F(CycleClutch, AScaleThatComesWithTheReleaseMovesNothing) {
  for (const bool in_one_tick : {true, false}) {
    clutch(true);
    step();
    const Vec3 there = out().pose.p;
    walk({0.05, 0.01, 0.02});
    put(CommandKind::kDisarm, DeviceRef{0});
    steps(50);
    clutch(false);
    if (!in_one_tick) step();
    SetMount scale = test::mountAt({}, 0, in_one_tick ? 2 : 1);
    scale.keeps_place = 1;
    put(CommandKind::kSetMount, scale);
    step();
    EXPECT_EQ(cycle->mount(0).scale(), in_one_tick ? 2 : 1);
    if (in_one_tick) {
      EXPECT_LT((out().pose.p - there).norm(), 1e-15);
    }
    bool told = false;
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      const ServoEvent& event = output->events.event[i];
      told = told || (event.kind == ServoEventKind::kMoved && vec3(event.point) == cycle->mount(0).pose().p);
    }
    EXPECT_TRUE(told) << "where it stands now";
    arm();
    steps(10);
  }
}

TEST_F(CycleClutch, PressedTheForceFadesAndNothingIsTensedWhenTheHandComesBack) {
  walk({0, 0, -0.004});
  ASSERT_NEAR(out().command.force.z(), 2, 1e-9);
  clutch(true);
  double last = 2;
  for (int i = 0; i < 60; ++i) {
    const double force = step().command.force.z();
    EXPECT_LE(force, last);
    EXPECT_LE(last - force, 2 * 1e-3 / Clutch::kFall_s + 1e-9);
    last = force;
  }
  EXPECT_EQ(last, 0);
  EXPECT_NEAR(out().pose.p.z(), 0, 1e-12) << "where the floor holds it, and where it was seen";
  walk({0, 0, 0.03});
  clutch(false);
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(step().command.force.isZero(0));
  EXPECT_NEAR(out().pose.p.z(), 0, 1e-12);
  EXPECT_EQ(weight(), 1);
  EXPECT_LE(walk({0, 0, 0.026}), 0.5e-3 * 500 + 0.05) << "and what the guard damps";
  EXPECT_NEAR(out().command.force.z(), 2, 1e-9) << "on the same side of it as before";
}

TEST_F(CycleClutch, AForceOfATenthOfANewtonFadesToo) {
  walk({0, 0, -0.0002});
  ASSERT_NEAR(out().command.force.z(), 0.1, 1e-9);
  clutch(true);
  for (int i = 1; i < 50; ++i) EXPECT_NEAR(step().command.force.z(), 0.1 * (1 - i * 1e-3 / Clutch::kFall_s), 1e-9) << i;
}

/** Of a spring that a program holds, the point stays where it was; it comes back slowly. */
TEST_F(CycleClutch, WhatAModelHoldsComesBackNoFasterThanItsPower) {
  put(CommandKind::kAddSession, SessionRef{0, 0, 1});
  hd_local_model wall{};
  wall.kind = HD_MODEL_PLANE;
  wall.lease_ns = 60'000'000'000;
  wall.material = {1000, 0, 0, 0};
  wall.normal[2] = 1;
  wall.origin[2] = 0.02;
  put(CommandKind::kLocalModel, wall, 0);
  walk({0, 0, 0.014});
  steps(20);
  ASSERT_NEAR(out().command.force.z(), 6, 1e-6);
  clutch(true);
  steps(60);
  walk({0.02, 0, 0.02});
  ASSERT_TRUE(out().command.force.isZero(0));
  ASSERT_NEAR(out().pose.p.z(), 0.014, 1e-12);
  clutch(false);
  step();
  const double energy = 0.5 * 1000 * 0.006 * 0.006;  // 18 mJ: not within 0.1 s, but 0.9 s.
  int ticks = 0;
  double last = 0;
  while (weight() < 1 && ticks < 2000) {
    const double w = weight();
    const double force = step().command.force.z();
    EXPECT_LE((weight() - w) * energy, Clutch::kMostPower * 1e-3 * (1 + 1e-6));
    EXPECT_GE(force, last);
    last = force;
    ++ticks;
  }
  EXPECT_NEAR(out().guard.energy, energy, 1e-3) << "and the guard knows whence it came";
  EXPECT_NEAR(ticks, 1000 * energy / Clutch::kMostPower, 3);
  EXPECT_NEAR(out().command.force.z(), 6, 1e-6);
  EXPECT_EQ(out().guard.fault, std::uint32_t{HD_FAULT_NONE});
}

/** Nothing is felt of a point that the hand is off: no torque either, also where there is no force beside it. */
TEST_F(CycleClutch, ATorqueFadesAsAForceDoes) {
  put(CommandKind::kAddSession, SessionRef{0, 0, 1});
  hd_client_force push{};
  push.lease_ns = 60'000'000'000;
  push.torque[1] = 0.1;
  put(CommandKind::kClientForce, push, 0);
  steps(40);
  ASSERT_NEAR(out().command.torque.y(), 0.1, 1e-6);
  clutch(true);
  double last = 0.1;
  for (int i = 0; i < 60; ++i) {
    const double torque = step().command.torque.y();
    EXPECT_LE(torque, last);
    EXPECT_LE(last - torque, 0.1 * 1e-3 / Clutch::kFall_s + 1e-9) << "not all at once";
    last = torque;
  }
  EXPECT_TRUE(out().command.torque.isZero(0));
  clutch(false);
  EXPECT_LT(step().command.torque.y(), 0.1 * 1e-3 / Clutch::kRise_s + 1e-9);
  steps(150);
  EXPECT_NEAR(out().command.torque.y(), 0.1, 1e-6);
}

TEST_F(CycleClutch, AButtonHoldsItAsLongAsItIsPressed) {
  clutch(false, 2);
  step();
  input->device[0].buttons = 1;
  step();
  EXPECT_FALSE(cycle->clutch(0).frozen()) << "another one";
  input->device[0].buttons = 2;
  step();
  EXPECT_TRUE(cycle->clutch(0).frozen());
  walk({0, 0, 0.08});
  input->device[0].buttons = 0;
  step();
  EXPECT_FALSE(cycle->clutch(0).frozen());
  EXPECT_NEAR(out().pose.p.z(), 0.05, 1e-15);
  clutch(false, 33);
  step();
  EXPECT_EQ(output->events.event[0].kind, ServoEventKind::kCommandRefused);
  EXPECT_EQ(cycle->clutch(0).order(0).button, 2u);
}

TEST_F(CycleClutch, HeldThroughAFaultAndANewArmingItStaysOff) {
  walk({0, 0, -0.002});
  clutch(true);
  put(CommandKind::kStop, StopOrder{0, 0});
  step();
  EXPECT_TRUE(out().command.force.isZero(0));
  walk({0, 0, -0.02});
  arm();
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(step().command.force.isZero(0));
  EXPECT_TRUE(out().command.enabled);
  clutch(false);
  for (int i = 0; i < 200; ++i) EXPECT_LE(step().command.force.norm(), 1e-9) << "at the floor again, not below it";
}

TEST_F(CycleClutch, AReadingThatIsNoneMovesNoPoint) {
  clutch(true);
  step();
  const Vec3 there = out().pose.p;
  const DeviceSample before = input->device[0];
  input->device[0].p.x() = NAN;
  clutch(false);
  steps(5);
  EXPECT_TRUE(cycle->clutch(0).frozen()) << "where the hand is, is not known";
  EXPECT_TRUE(cycle->mount(0).identity());
  input->device[0] = before;
  at({0.01, 0, 0.05});
  EXPECT_FALSE(cycle->clutch(0).frozen());
  EXPECT_NEAR((cycle->mount(0).toWorld(Pose{{0.01, 0, 0.05}, before.q}).p - there).norm(), 0, 1e-12);
}

TEST_F(CycleClutch, AMountThatIsSetMeanwhileIsWhereThePointIs) {
  put(CommandKind::kDisarm, DeviceRef{0});
  clutch(true);
  steps(3);
  put(CommandKind::kSetMount, test::mountAt({{0.5, 0, 0}, Quat::Identity()}));
  step();
  EXPECT_EQ(out().pose.p, Vec3(0.5, 0, 0.05));
  at({0, 0, 0.07});
  EXPECT_EQ(out().pose.p, Vec3(0.5, 0, 0.05)) << "and stands still there";
  EXPECT_EQ(output->events.count, 0u);
  clutch(false);
  step();
  ASSERT_EQ(output->events.count, 1u);
  EXPECT_EQ(output->events.event[0].kind, ServoEventKind::kMoved) << "for those who say where it stands";
  EXPECT_NEAR(output->events.event[0].point[2], -0.02, 1e-15);
}

/** As far as a mount may be, and the point comes along from there. */
TEST_F(CycleClutch, NoSeriesOfThemLeadsTooFar) {
  put(CommandKind::kDisarm, DeviceRef{0});
  steps(3);
  for (int i = 0; i < 1200; ++i) {
    at({0, 0, 0.05});
    clutch(true);
    steps(2);
    at({-0.1, 0, 0.05});
    clutch(false);
    steps(2);
  }
  EXPECT_EQ(cycle->mount(0).pose().p.x(), Mount::kFarthest);
  EXPECT_TRUE(Mount::valid(cycle->mount(0).order(0)));
}

/** It is not pushed by a hand that does not feel it. */
TEST_F(CycleClutch, ABodyIsPushedByWhatIsFelt) {
  const Pose X{{0, 0, 0.02}, Quat::Identity()};
  add(test::solid(kClutchBody, ShapeKind::kSphere, {500, 0, 0, 0}, X, {0.01, 0, 0}));
  SetBody body{kClutchBody, 0, 10, {}, {1e-3, 1e-3, 1e-3, 0, 0, 0}, 0};
  put(CommandKind::kSetBody, body);
  double felt = 0;
  const auto go = [&](const Vec3& p) {  // It touches nothing else, which it is to be told.
    ToolContacts none{};
    none.device = kMaxDevices;
    none.object = kClutchBody;
    answer(none);
    felt += 1e-3 * at(p).guard.by_source[HD_SOURCE_SURFACE].z();
  };
  while (input->device[0].p.z() > 0.028) go(input->device[0].p - Vec3(0, 0, 0.5e-3));
  ASSERT_GT(out().command.force.z(), 0.9);
  clutch(true);
  for (int i = 0; i < 60; ++i) go(input->device[0].p);
  const auto speed = [&] { return cycle->scene().slot(objectSlot(kClutchBody)).V_WO.v.z(); };
  const double before = speed();
  EXPECT_NEAR(before, -felt / body.mass, 1e-6);
  walk({0, 0, 0.01});
  EXPECT_EQ(speed(), before);
}

TEST_F(CycleClutch, ARecordingBeginsWithIt) {
  put(CommandKind::kDisarm, DeviceRef{0});
  for (int i = 0; i < 200 && cycle->deviceGuard(0).armed(); ++i) step();
  put(CommandKind::kSetMount, test::mountAt({{0.02, 0, 0.3}, Quat(0.8, 0, 0.6, 0)}, 0, 1.5));
  clutch(true, 3);
  steps(5);
  ASSERT_EQ(cycle->mount(0).scale(), 1.5);
  const auto begun = [&] {
    CycleStart start;
    start.config = cycle->config();
    restate(*cycle, input->now_ns, start.orders);
    return makeCycle(start, meshes);
  };
  EXPECT_EQ(begun()->clutch(0).order(0).held, 1u);
  EXPECT_EQ(begun()->clutch(0).order(0).button, 3u);

  const auto bits = [](const Vec3& x) { return std::array{x.x(), x.y(), x.z()}; };
  const auto goOn = [&](const char* when) {
    const auto again = begun();
    for (int i = 0; i < 20; ++i) {
      const auto there = std::make_unique<CycleOutput>();
      if (i == 10) clutch(false);
      const std::uint32_t orders = input->command_count;
      step();
      input->command_count = orders;
      again->step(*input, *there);
      input->command_count = 0;
      ASSERT_EQ(bits(there->device[0].pose.p), bits(out().pose.p)) << when << ", tick " << i;
      ASSERT_EQ(bits(again->mount(0).pose().p), bits(cycle->mount(0).pose().p)) << when << ", tick " << i;
    }
  };
  const Vec3 there = out().pose.p;
  walk({0.03, -0.02, 0.04});
  ASSERT_EQ(out().pose.p, there) << "the point stands still, the hand has gone";
  goOn("off its point");

  // Let go while there is no reading: the place comes along with the next one.
  clutch(true);
  steps(5);
  input->device[0].q.coeffs().setZero();
  clutch(false);
  step();
  input->device[0].q.setIdentity();
  input->device[0].p = {0, 0, 0.01};
  goOn("let go");
}

TEST_F(CycleClutch, ATouchIsToldWithWhatIsFeltOfIt) {
  const auto touched = [&](double z, bool begins) {
    const auto kind = begins ? ServoEventKind::kTouch : ServoEventKind::kUntouch;
    put(CommandKind::kObjectPose, poseMessage(kClutchFloor, {{0, 0, z}, Quat::Identity()}));
    for (int i = 0; i < 5; ++i) {
      step();
      for (std::uint32_t e = 0; e < output->events.count; ++e)
        if (output->events.event[e].kind == kind) return output->events.event[e].force;
    }
    return -1.0;
  };
  EXPECT_NEAR(touched(0.051, true), 0.5, 1e-9);
  (void)touched(0, false);
  clutch(true);
  steps(60);
  EXPECT_EQ(touched(0.051, true), 0) << "the wall has come to the point, the hand is not there";
}

class ScaledClutch : public CycleClutch {
 protected:
  ScaledClutch() : CycleClutch(4) {}
};

TEST_F(ScaledClutch, ThePointStandsWhereItWasInTheWorld) {
  ASSERT_NEAR(out().pose.p.z(), 0.2, 1e-15);
  clutch(true);
  step();
  walk({0, 0, 0});
  clutch(false);
  step();
  EXPECT_NEAR(out().pose.p.z(), 0.2, 1e-15);
  EXPECT_EQ(cycle->mount(0).scale(), 4);
  walk({0, 0, -0.051});
  EXPECT_NEAR(out().command.force.z(), 2, 1e-9) << "4 mm deep of the world";
}

}  // namespace
}  // namespace hapticd
