// A device that stands somewhere else: what it feels there, who sees what, and when it may be moved.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "rt/cycle/cycle_start.h"
#include "tests/support/random.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

using test::mountAt;

constexpr std::uint32_t kThing = makeObjectId(1, 1);
Quat turnedAboutZ(double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ())); }
Quat turnedAboutX(double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitX())); }

/** One device above a floor, in the air. */
class CycleMount : public testing::Test, protected test::SteppedCycle {
 protected:
  CycleMount() : SteppedCycle(test::openConfig(10)) {
    add(test::solid(kThing, ShapeKind::kPlane, {500, 0, 0, 0}));
    at({0, 0, 0.05});
  }
  /** There at half a metre per second. */
  void walk(const Vec3& to) {
    while (input->device[0].p != to) at(input->device[0].p + clampNorm(to - input->device[0].p, 0.5e-3));
    for (int i = 0; i < 20; ++i) at(to);
  }
  /** Whether it was taken. */
  ErrorCode mount(const SetMount& order) {
    put(CommandKind::kSetMount, order);
    step();
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      const ServoEvent& event = output->events.event[i];
      if (event.kind == ServoEventKind::kCommandRefused) return static_cast<ErrorCode>(event.value);
    }
    return ErrorCode::kOk;
  }
};

TEST_F(CycleMount, AForceActsWhereTheDeviceStands) {
  // On its left side: its own x is up and down, its z to the left.
  const Pose X{{0.2, 0.1, 0.3}, Quat(Eigen::AngleAxisd(M_PI_2, Vec3::UnitY()))};
  ASSERT_EQ(mount(mountAt(X)), ErrorCode::kOk);
  walk({0.29, 0, 0});  // 1 cm above the floor
  arm();
  for (int i = 0; i < 10; ++i) step();
  EXPECT_TRUE(output->device[0].command.enabled);
  EXPECT_NEAR(output->device[0].pose.p.z(), 0.01, 1e-12);
  EXPECT_TRUE(output->device[0].command.force.isZero(0));
  walk({0.302, 0, 0});  // and 2 mm into it
  EXPECT_LT((output->device[0].contact.force - Vec3(0, 0, 1)).norm(), 1e-9) << "up in the world";
  EXPECT_LT((output->device[0].command.force - Vec3(-1, 0, 0)).norm(), 1e-9) << "along its own x";
  EXPECT_EQ(output->device[0].contact.object, kThing);
}

TEST_F(CycleMount, IsRefusedWhileForcesMayFlow) {
  const SetMount away = mountAt({{0, 0, -0.1}, turnedAboutZ(1)});
  arm();
  step();
  ASSERT_TRUE(cycle->deviceGuard(0).armed());
  EXPECT_EQ(mount(away), ErrorCode::kWouldBlock);
  EXPECT_TRUE(cycle->mount(0).identity());
  EXPECT_TRUE(cycle->deviceGuard(0).armed()) << "a refusal changes nothing";
  walk({0, 0, -0.002});
  ASSERT_GT(output->device[0].command.force.z(), 0.9);
  // Slow to be lowered: it is not off before it is at zero.
  DeviceLimits slow = limitsOrder(0, cycle->deviceGuard(0).limits(), false);
  slow.force_slew = 20;
  put(CommandKind::kDeviceLimits, slow);
  put(CommandKind::kDisarm, DeviceRef{0});
  step();
  int lowering = 0;
  while (mount(away) != ErrorCode::kOk) {
    ASSERT_TRUE(cycle->mount(0).identity());
    ASSERT_LT(++lowering, 100);
  }
  EXPECT_GT(lowering, 10);
  EXPECT_TRUE(output->device[0].command.force.isZero(0));
  EXPECT_FALSE(cycle->mount(0).identity());
}

TEST_F(CycleMount, OneThatHasFailedMayBeMovedAndBeginsWithASmallForce) {
  put(CommandKind::kStop, StopOrder{0, 0});
  ASSERT_EQ(mount(mountAt({{0, 0, -0.0505}, Quat::Identity()})), ErrorCode::kOk) << "now half a millimetre deep";
  arm();
  double last = 0;
  for (int i = 0; i < 50; ++i) {
    const double now = step().command.force.norm();
    EXPECT_LE(now - last, 1e6 * 1e-3);
    last = now;
  }
  EXPECT_TRUE(output->device[0].command.enabled);
}

TEST_F(CycleMount, AHandThatIsSomewhereElseAtOnceHasNotMovedThere) {
  at({0, 0, 0.001});
  ASSERT_EQ(mount(mountAt({{0, 0, -0.005}, Quat::Identity()})), ErrorCode::kOk);
  EXPECT_EQ(output->device[0].velocity.v, Vec3(0, 0, 0)) << "the device has not moved";
  EXPECT_NEAR(output->device[0].pose.p.z(), -0.004, 1e-15);
}

TEST_F(CycleMount, AHandThatIsSomewhereElseAtOnceMeetsNothingOnItsWay) {
  add(test::solid(makeObjectId(2, 1), ShapeKind::kSphere, {500, 0, 0, 0}, {{0, 0, 0.03}, Quat::Identity()},
                  {0.005, 0, 0}));
  step();
  ASSERT_EQ(mount(mountAt({{0, 0, -0.04}, Quat::Identity()})), ErrorCode::kOk) << "from 5 cm to 1 cm";
  EXPECT_EQ(output->device[0].contact.object, 0u);
  EXPECT_EQ(step().contact.object, 0u) << "nothing holds it back";
}

TEST_F(CycleMount, WhatIsNoPlaceIsRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  const Pose fine{{0.1, 0, 0}, turnedAboutX(0.5)};
  ASSERT_EQ(mount(mountAt(fine)), ErrorCode::kOk);
  for (const double bad : {kNan, kInf, -kInf, 101.0, -1e300}) {
    for (int i = 0; i < 3; ++i) {
      SetMount order = mountAt({});
      order.p[i] = bad;
      EXPECT_EQ(mount(order), ErrorCode::kInvalidArgument) << bad;
    }
  }
  for (const double bad : {kNan, kInf, 2.0, -1e200}) {
    for (int i = 0; i < 4; ++i) {
      SetMount order = mountAt({});
      order.q[i] = bad;
      EXPECT_EQ(mount(order), ErrorCode::kInvalidArgument) << bad;
    }
  }
  SetMount none = mountAt({});
  none.q[0] = 0;
  EXPECT_EQ(mount(none), ErrorCode::kInvalidArgument);
  for (const double bad : {kNan, kInf, -1.0, 0.009, 101.0, 1e-300}) {
    EXPECT_EQ(mount(mountAt({}, 0, bad)), ErrorCode::kInvalidArgument) << bad;
  }
  EXPECT_EQ(mount(mountAt(fine, 1)), ErrorCode::kInvalidArgument) << "there is no such device";
  EXPECT_EQ(cycle->mount(0).pose().p, fine.p);
}

TEST_F(CycleMount, AnArmsWeightIsCarriedAlongItsOwnVertical) {
  input->device[0].gravity = {0, 0, 0.5};
  for (const auto& [turn, part] : {std::pair{0.0, 1.0}, {0.4, std::cos(0.4)}, {M_PI_2, 0.0}, {M_PI, -1.0}}) {
    put(CommandKind::kDisarm, DeviceRef{0});
    for (int i = 0; i < 3; ++i) step();
    ASSERT_EQ(mount(mountAt({{0, 0, 0.2}, turnedAboutX(turn)})), ErrorCode::kOk);
    arm();
    for (int i = 0; i < 20; ++i) step();
    EXPECT_LT((output->device[0].command.force - Vec3(0, 0, 0.5 * part)).norm(), 1e-9) << turn;
  }
}

TEST_F(CycleMount, TheOrderMadeOfItGivesItAgainBitForBit) {
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    SetMount order = mountAt(random.pose(1), 0, random.in(0.01, 100));
    for (double& x : order.q) x *= random.in(0.96, 1.04);
    const Mount one(order), again(one.order(0));
    ASSERT_EQ(one.pose().q.coeffs(), again.pose().q.coeffs());
    ASSERT_EQ(one.pose().p, again.pose().p);
    ASSERT_EQ(one.scale(), again.scale());
    ASSERT_NEAR(one.pose().q.norm(), 1, 1e-15);
  }
  EXPECT_TRUE(Mount(mountAt({{0, 0, 0}, Quat(-1, 0, 0, 0)})).identity()) << "a whole turn";
}

TEST_F(CycleMount, AMetreOfTheHandIsAsManyOfTheWorldAsItsScale) {
  ASSERT_EQ(mount(mountAt({{0, 0, 0.1}, Quat::Identity()}, 0, 4)), ErrorCode::kOk);
  at({0, 0, 0.05});
  EXPECT_NEAR(output->device[0].pose.p.z(), 0.3, 1e-15);
  arm();
  for (int i = 0; i < 10; ++i) step();
  walk({0, 0, -0.026});
  EXPECT_NEAR(output->device[0].pose.p.z(), -0.004, 1e-15);
  EXPECT_NEAR(output->device[0].contact.depth, 0.004, 1e-12) << "of the world";
  EXPECT_NEAR(output->device[0].command.force.z(), 2, 1e-9) << "500 N/m there, 2000 N/m to the hand";
}

TEST_F(CycleMount, ABallInPlaceOfThePointIsAsLargeAsItIsSaidInTheWorld) {
  put(CommandKind::kDeviceRadius, DeviceRadius{0, 0, 0.002});
  ASSERT_EQ(mount(mountAt({}, 0, 4)), ErrorCode::kOk);
  arm();
  for (int i = 0; i < 10; ++i) step();
  walk({0, 0, 0.00051});
  EXPECT_EQ(output->device[0].contact.object, 0u) << "2.04 mm above the floor";
  walk({0, 0, 0.0001});
  EXPECT_NEAR(output->device[0].command.force.z(), 500 * (0.002 - 0.0004), 1e-9);
}

/** A metre is longer there, a turn is a turn. */
TEST_F(CycleMount, WhatADeviceMeasuresOfItsSpeedIsOfTheWorld) {
  ASSERT_EQ(mount(mountAt({{0.2, 0.1, 0.3}, Quat(Eigen::AngleAxisd(M_PI_2, Vec3::UnitY()))}, 0, 4)), ErrorCode::kOk);
  input->device[0].has_velocity = true;
  input->device[0].v = {0.1, 0.2, 0};
  input->device[0].w = {1, 2, 0};
  at(input->device[0].p);
  EXPECT_LT((output->device[0].velocity.v - Vec3(0, 0.8, -0.4)).norm(), 1e-12);
  EXPECT_LT((output->device[0].velocity.w - Vec3(0, 2, -1)).norm(), 1e-12);
}

/** What its driver and its guard know is not scaled: how fast the hand may be, and what damping it can bear. */
TEST_F(CycleMount, ALargeWorldIsNoFasterHand) {
  ASSERT_EQ(mount(mountAt({}, 0, 100)), ErrorCode::kOk);
  arm();
  for (int i = 0; i < 10; ++i) step();
  for (int i = 0; i < 20; ++i) at(input->device[0].p + Vec3(0, 0, 0.5e-3));
  EXPECT_NEAR(output->device[0].velocity.v.z(), 50, 1e-6) << "of the world";
  EXPECT_EQ(output->device[0].guard.fault, std::uint32_t{HD_FAULT_NONE}) << "half of the 1 m/s that the limit says";
}

TEST_F(CycleMount, WhatAHandIsAskedToDoIsOfTheWorld) {
  ASSERT_EQ(mount(mountAt({{0, 0, 1}, turnedAboutX(M_PI)}, 0, 10)), ErrorCode::kOk);
  hd_intent wish{};
  store(Vec3(0.5, 0, 0.9), wish.p);
  store(turnedAboutX(M_PI), wish.q);
  put(CommandKind::kIntent, wish);
  step();
  ASSERT_TRUE(output->device[0].has_intent);
  EXPECT_LT((output->device[0].intent.p - Vec3(0.05, 0, 0.01)).norm(), 1e-15);
}

/** So that power is what it was: a lever of the hand is one of the world, scaled. */
TEST_F(CycleMount, ATorqueOfTheWorldIsAsMuchLessInTheHand) {
  ASSERT_EQ(mount(mountAt({}, 0, 4)), ErrorCode::kOk);
  put(CommandKind::kAddSession, SessionRef{0, 0, 1});
  arm();
  for (int i = 0; i < 10; ++i) step();
  hd_client_force push{};
  push.lease_ns = 1'000'000'000;
  push.force[0] = 1;
  push.torque[2] = 0.2;
  put(CommandKind::kClientForce, push, 0);
  for (int i = 0; i < 10; ++i) step();
  EXPECT_NEAR(output->device[0].command.force.x(), 1, 1e-9);
  EXPECT_NEAR(output->device[0].command.torque.z(), 0.05, 1e-9);
  const Wrench told = cycle->mount(0).toWorld(Wrench{{1, 2, 3}, {0.05, 0, 0}});
  EXPECT_EQ(told.force, Vec3(1, 2, 3));
  EXPECT_EQ(told.torque, Vec3(0.2, 0, 0));
}

/** As recordings and configurations said it that knew of no scale. */
TEST_F(CycleMount, AsFarAndAsLargeAsItMayBeIsTakenAndNoFarther) {
  for (const double sense : {-1.0, 1.0}) {
    EXPECT_TRUE(Mount::valid(mountAt({{0, sense * Mount::kFarthest, 0}, Quat::Identity()})));
    EXPECT_FALSE(Mount::valid(mountAt({{0, sense * 100.001, 0}, Quat::Identity()})));
  }
  for (const double scale : {0.0, 0.01, 1.0, 100.0}) EXPECT_TRUE(Mount::valid(mountAt({}, 0, scale))) << scale;
  for (const double scale : {0.0099, 100.1, -1.0}) EXPECT_FALSE(Mount::valid(mountAt({}, 0, scale))) << scale;
  for (const double squared : {0.89, 0.91, 1.09, 1.11}) {
    SetMount order = mountAt({});
    order.q[0] = std::sqrt(squared);
    EXPECT_EQ(Mount::valid(order), std::abs(squared - 1) < 0.1) << squared;
  }
}

TEST_F(CycleMount, NoScaleIsOne) {
  EXPECT_EQ(Mount(mountAt({}, 0, 0)).scale(), 1);
  EXPECT_TRUE(Mount(mountAt({}, 0, 0)).identity());
  EXPECT_FALSE(Mount(mountAt({}, 0, 2)).identity());
}

/** What the guard's observer books is of the sum: none of it is lost, however the axes share it. */
TEST_F(CycleMount, PowerIsSharedAmongTheDevicesAxesAndNoneIsLost) {
  Random random(8);
  for (int i = 0; i < 2000; ++i) {
    const Mount mount(random.pose(1), random.in(0.5, 2));
    const Vec3 power = random.vector(50);
    ASSERT_NEAR(mount.powerToDevice(power).sum(), power.sum() / mount.scale(), 1e-12);
    ASSERT_GE(mount.powerToDevice(power.cwiseAbs()).minCoeff(), 0) << "what is given takes nothing along any axis";
  }
  const Mount quarter(Pose{{0, 0, 0}, turnedAboutZ(M_PI_2)});  // Its y is the world's -x.
  EXPECT_LT((quarter.powerToDevice({1, 2, 3}) - Vec3(2, 1, 3)).norm(), 1e-12);
}

TEST_F(CycleMount, ARecordingBeginsWithIt) {
  ASSERT_EQ(mount(mountAt({{0.1, 0.2, 0.3}, turnedAboutX(0.5)})), ErrorCode::kOk);
  CycleStart start;
  start.config = cycle->config();
  restate(*cycle, input->now_ns, start.orders);
  const auto again = makeCycle(start, meshes);
  EXPECT_EQ(again->mount(0).pose().p, cycle->mount(0).pose().p);
  EXPECT_EQ(again->mount(0).pose().q.coeffs(), cycle->mount(0).pose().q.coeffs());
}

/** As a device's other orders (whoRestates()). */
TEST_F(CycleMount, ARecordingBeginsWithTheSpringOfAGrip) {
  put(CommandKind::kSetGrip, SetGrip{0, 0, 5, 0.2});
  step();
  CycleStart start;
  start.config = cycle->config();
  restate(*cycle, input->now_ns, start.orders);
  const auto again = makeCycle(start, meshes);
  EXPECT_EQ(again->grip(0).stiffness, 5);
  EXPECT_EQ(again->grip(0).width, 0.2);
}

/** The daemon goes on with it too: else what a program that hangs has asked for came back. */
TEST_F(CycleMount, NorDoesAProgramThatIsLostComeBackWhereARecordingBegins) {
  put(CommandKind::kAddSession, SessionRef{0, 0, 1});
  hd_client_force push{};
  push.lease_ns = 10'000'000'000;
  push.force[0] = 1;
  put(CommandKind::kClientForce, push, 0);
  for (int i = 0; i < 10; ++i) step();
  ASSERT_EQ(output->device[0].guard.by_source[HD_SOURCE_CLIENT].x(), 1);
  put(CommandKind::kLoseSession, SessionRef{0, 0, 1});
  for (int i = 0; i < 100; ++i) step();
  ASSERT_TRUE(output->device[0].guard.by_source[HD_SOURCE_CLIENT].isZero(0));
  CycleStart start;
  start.config = cycle->config();
  start.now_ns = input->now_ns;
  restate(*cycle, input->now_ns, start.orders);
  const auto again = makeCycle(start, meshes);
  EXPECT_EQ(again->session(0).life(), SessionShare::Life::kLost);
  const auto there = std::make_unique<CycleOutput>();
  for (int i = 0; i < 100; ++i) {
    step();
    again->step(*input, *there);
    ASSERT_TRUE(there->device[0].guard.by_source[HD_SOURCE_CLIENT].isZero(0)) << i;
  }
}

}  // namespace
}  // namespace hapticd
