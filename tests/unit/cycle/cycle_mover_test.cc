// What a session has given a velocity moves as long as the session lives: then nobody is there who would end the
// motion.
#include <gtest/gtest.h>

#include <cmath>

#include "rt/cycle/cycle_start.h"
#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

class CycleMover : public testing::Test, protected test::SteppedCycle {
 protected:
  CycleMover() {
    for (const std::uint32_t slot : {kLost, kOther}) session(CommandKind::kAddSession, slot);
    for (const std::uint32_t id : {kHis, kTheirs, kControls})
      add(test::solid(id, ShapeKind::kBox, {}, {}, Vec3(1, 1, 1)));
    AddObject child = test::solid(kChild, ShapeKind::kBox, {}, {}, Vec3(1, 1, 1));
    child.parent = kHis;
    add(child);
    move(kHis, kLost);
    move(kTheirs, kOther);
    move(kControls, kControlSession);
    for (int i = 0; i < 10; ++i) step();
  }
  void session(CommandKind kind, std::uint32_t slot) { put(kind, SessionRef{slot, 0, 7}); }
  Command& move(std::uint32_t id, std::uint32_t by, const Vec3& p = Vec3::Zero()) {
    return put(CommandKind::kObjectPose, poseMessage(id, {p, Quat::Identity()}, {kV, Vec3::Zero()}), by);
  }
  const SceneObject& object(std::uint32_t id) { return *cycle->scene().find(id); }
  double x(std::uint32_t id) { return object(id).X_WO.p.x(); }
  void expectStill(std::uint32_t id) {
    const double from = x(id);
    for (int i = 0; i < 20; ++i) {
      step();
      EXPECT_EQ(x(id), from);
      EXPECT_TRUE(object(id).V_WO.v.isZero(0)) << "nor is it felt to move";
    }
  }
  void expectMoving(std::uint32_t id) {
    const double from = x(id);
    for (int i = 0; i < 20; ++i) step();
    EXPECT_NEAR(x(id) - from, 20 * kV.x() * 1e-9 * static_cast<double>(cycle->config().period_ns), 1e-12);
  }

  static constexpr std::uint32_t kHis = makeObjectId(1, 1), kTheirs = makeObjectId(2, 1),
                                 kControls = makeObjectId(3, 1), kChild = makeObjectId(4, 1);
  static constexpr std::uint32_t kLost = 2, kOther = 3;  ///< Sessions.
  const Vec3 kV{0.25, 0, 0};
};

TEST_F(CycleMover, OfALostSessionNothingGoesOn) {
  const std::uint32_t told = object(kHis).client_edits[SceneObject::kPlace];
  const double from = x(kHis);
  session(CommandKind::kLoseSession, kLost);
  step();
  EXPECT_EQ(x(kHis), from);
  EXPECT_EQ(object(kHis).client_edits[SceneObject::kPlace], told + 1) << "the other groups learn it";
  step();
  expectStill(kHis);
  expectStill(kChild);
  expectMoving(kTheirs);
  expectMoving(kControls);
}

TEST_F(CycleMover, NorOfOneThatIsFreedAtOnce) {
  session(CommandKind::kFreeSession, kLost);
  step();
  step();
  expectStill(kHis);
  expectMoving(kTheirs);
}

TEST_F(CycleMover, NorByWhatItHadSentAhead) {
  move(kHis, kLost, Vec3(0.004, 0, 0)).at_tick = input->tick + 5;
  session(CommandKind::kLoseSession, kLost);
  for (int i = 0; i < 5; ++i) step();
  EXPECT_EQ(x(kHis), 0.004) << "the place was meant for that tick";
  for (int i = 0; i < 80; ++i) step();  // A place that comes by itself is a motion for a while.
  expectStill(kHis);
}

TEST_F(CycleMover, ComeBackItMovesThingsAgain) {
  session(CommandKind::kLoseSession, kLost);
  step();
  session(CommandKind::kReviveSession, kLost);
  step();
  expectStill(kHis);
  move(kHis, kLost);
  step();
  expectMoving(kHis);
}

// A program that hung pressed a wall into the hand: its library's heartbeat went on.
TEST_F(CycleMover, WhatHasALeaseStandsWhenThatRunsOut) {
  constexpr int kTicks = 40;
  const double period = 1e-9 * static_cast<double>(cycle->config().period_ns);
  const auto lease = static_cast<std::uint32_t>(std::lround(kTicks * period * 1e6));
  const auto push = [&] { move(kHis, kLost).as<hd_object_pose>().lease_us = lease; };
  const std::uint32_t told = object(kHis).client_edits[SceneObject::kPlace];
  for (int i = 0; i < 5; ++i) {  // Renewed in time it goes on.
    push();
    for (int k = 0; k < kTicks - 2; ++k) step();
    EXPECT_NEAR(x(kHis), (kTicks - 3) * kV.x() * period, 1e-12) << i;
  }
  EXPECT_EQ(object(kHis).client_edits[SceneObject::kPlace], told + 5);
  for (int k = 0; k < 3; ++k) step();
  EXPECT_EQ(object(kHis).client_edits[SceneObject::kPlace], told + 6) << "the other groups learn it";
  step();
  expectStill(kHis);
  expectStill(kChild);
  EXPECT_NEAR(x(kHis), kTicks * kV.x() * period, kV.x() * period + 1e-12);
  expectMoving(kTheirs);
  move(kHis, kLost);
  step();
  expectMoving(kHis);
}

TEST_F(CycleMover, PeriodsThatAreMissedAreOfTheLease) {
  constexpr std::uint32_t kMissed = 100;
  move(kHis, kLost).as<hd_object_pose>().lease_us =
      static_cast<std::uint32_t>(std::lround(40e-3 * static_cast<double>(cycle->config().period_ns)));
  for (int i = 0; i < 10; ++i) step();
  input->missed = kMissed;
  input->tick += kMissed;
  input->now_ns += kMissed * cycle->config().period_ns;
  step();
  input->missed = 0;
  EXPECT_NEAR(x(kHis), 40 * kV.x() * 1e-9 * static_cast<double>(cycle->config().period_ns), 1e-12) << "no farther";
  step();
  expectStill(kHis);
}

// A recording that begins lets the servo stand for some periods, which nobody missed.
TEST_F(CycleMover, GoesOnWhileTheServoStands) {
  const double from = x(kHis), period = 1e-9 * static_cast<double>(cycle->config().period_ns);
  input->tick += 9;
  input->now_ns += 9 * cycle->config().period_ns;
  step();
  EXPECT_NEAR(x(kHis) - from, 10 * kV.x() * period, 1e-12);
  step();
  EXPECT_NEAR(x(kHis) - from, 11 * kV.x() * period, 1e-12);
}

TEST_F(CycleMover, WhatAHandHoldsIsWhereThatIs) {
  put(CommandKind::kAttachTool, test::attachBox(kTheirs, {2, 2, 2}, DeviceInfo{}));
  for (int i = 0; i < 20; ++i) at(Vec3::Zero());
  const Vec3 p = object(kTheirs).X_WO.p;
  for (int i = 0; i < 5; ++i) {
    move(kTheirs, kOther, Vec3(0.005, 0, 0));
    at(Vec3::Zero());
    EXPECT_LT((object(kTheirs).X_WO.p - p).norm(), 1e-6);
    EXPECT_LT(object(kTheirs).V_WO.v.norm(), 1e-3);
  }
}

TEST_F(CycleMover, WhatAnotherHasMovedSinceGoesOn) {
  move(kHis, kControlSession);
  step();
  session(CommandKind::kLoseSession, kLost);
  expectMoving(kHis);
  session(CommandKind::kFreeSession, kLost);
  session(CommandKind::kAddSession, kLost);
  step();
  session(CommandKind::kLoseSession, kLost);
  expectMoving(kHis);
}

/** As where a recording begins: control gives the new cycle the scene, and does not know who moves what. */
TEST_F(CycleMover, OfALostSessionNothingGoesOnInACycleThatWasMadeAnew) {
  CycleStart start;
  start.config = cycle->config();
  start.tick = input->tick;
  start.now_ns = input->now_ns;
  for (const std::uint32_t id : {kHis, kTheirs}) {
    start.orders.push_back(
        makeCommand(CommandKind::kAddObject, test::solid(id, ShapeKind::kBox, {}, {}, Vec3(1, 1, 1))));
    const SceneObject& before = object(id);
    start.orders.push_back(makeCommand(CommandKind::kObjectPose, poseMessage(id, before.X_PO, before.V_PO)));
  }
  // Control has given this one another velocity, which the cycle before has not taken.
  start.orders.push_back(
      makeCommand(CommandKind::kAddObject, test::solid(kChild, ShapeKind::kBox, {}, {}, Vec3(1, 1, 1))));
  start.orders.push_back(makeCommand(CommandKind::kObjectPose, poseMessage(kChild, Pose{}, {2 * kV, Vec3::Zero()})));
  move(kChild, kLost);
  move(kTheirs, kOther, {x(kTheirs), 0, 0}).as<hd_object_pose>().lease_us = 50'000;
  step();
  start.orders[3] =
      makeCommand(CommandKind::kObjectPose, poseMessage(kTheirs, object(kTheirs).X_PO, {kV, Vec3::Zero()}));
  const std::uint32_t left = cycle->scene().leaseOf(kTheirs);
  EXPECT_NEAR(left, 49'000, 1'000);
  restate(*cycle, start.now_ns, start.orders);
  cycle = makeCycle(start, meshes);
  step();
  EXPECT_EQ(object(kHis).client_edits[SceneObject::kPlace], 0u) << "what control has ordered it is not told";
  expectMoving(kHis);
  session(CommandKind::kLoseSession, kLost);
  step();
  step();
  expectStill(kHis);
  EXPECT_LT(cycle->scene().leaseOf(kTheirs), left);
  EXPECT_GT(cycle->scene().leaseOf(kTheirs), 1u) << "as much as was left";
  for (int i = 0; i < 50; ++i) step();
  expectStill(kTheirs);
  EXPECT_FALSE(object(kChild).V_PO.v.isZero(0));
}

}  // namespace
}  // namespace hapticd
