// Who may energise a device, stepped by hand.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

/** Every event so far, by kind. */
class Heard {
 public:
  explicit Heard(Core& core) : core_(core), id_(core.events().subscribe(0, [] {})) {}
  std::vector<EventKind> kinds() {
    std::vector<EventKind> out;
    for (const Event& e : core_.events().take(id_).events) out.push_back(e.kind);
    return out;
  }

 private:
  Core& core_;
  std::uint64_t id_;
};

TEST(Lease, OneHolderAtATimeAndItIsNamed) {
  Bench bench;
  Session* first = bench.live();
  Session* second = bench.live();
  ASSERT_TRUE(bench.core.acquireLease(first->id).ok());
  EXPECT_TRUE(bench.core.acquireLease(first->id).ok()) << "asking again changes nothing";
  const auto refused = bench.core.acquireLease(second->id);
  EXPECT_EQ(refused.error().code, ErrorCode::kLeaseHeld);
  EXPECT_NE(refused.error().what.find("tester"), std::string::npos);
  EXPECT_EQ(bench.core.releaseLease(second->id).error().code, ErrorCode::kLeaseRequired);
  EXPECT_TRUE(bench.core.releaseLease(first->id).ok());
  EXPECT_TRUE(bench.core.acquireLease(second->id).ok());
}

TEST(Lease, ArmingTakesItAndOnlyTheHolderDisarms) {
  Bench bench;
  Session* first = bench.live();
  Session* second = bench.live();
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u) << "off until armed";
  EXPECT_TRUE(bench.core.disarm(first->id).ok()) << "so it is; who ends need not know whether it was armed";
  ASSERT_TRUE(bench.arm(first->id).ok());
  EXPECT_EQ(bench.device().lease, first->id);
  EXPECT_EQ(bench.arm(second->id).error().code, ErrorCode::kLeaseHeld);
  EXPECT_EQ(bench.core.disarm(second->id).error().code, ErrorCode::kLeaseRequired);
  bench.step(20);
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  ASSERT_TRUE(bench.core.disarm(first->id).ok());
  bench.step(5);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(bench.device().lease, first->id) << "disarming keeps the lease";
}

TEST(Lease, TheHoldersDeathDisarmsAndSaysSo) {
  Bench bench;
  Heard heard(bench.core);
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(20);
  bench.core.disconnect(bench.connection);
  bench.step(5);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(bench.device().lease, 0u);
  const auto kinds = heard.kinds();
  EXPECT_THAT(kinds, testing::IsSupersetOf(
                         {EventKind::kLeaseTaken, EventKind::kArmed, EventKind::kLeaseLost, EventKind::kDisarmed}));
}

TEST(Lease, WhoHasNoSessionHasNothing) {
  Bench bench;
  constexpr std::uint64_t kNobody = 4711;
  EXPECT_FALSE(bench.core.acquireLease(kNobody).ok());
  EXPECT_FALSE(bench.core.releaseLease(kNobody).ok());
  EXPECT_FALSE(bench.arm(kNobody).ok());
  EXPECT_FALSE(bench.core.disarm(kNobody).ok());
}

TEST(Lease, WhatIsNotCalibratedIsNotArmed) {
  for (const Calibration state : {Calibration::kNeeded, Calibration::kRunning}) {
    Bench bench;
    Session* session = bench.live();
    bench.scripted[0]->calibrated = state;
    EXPECT_EQ(bench.arm(session->id).error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(bench.arm(session->id).error().remedy, "calibrate it, then arm");
    const_cast<DeviceInfo&>(bench.scripted[0]->info()).calibration_style = "put the stylus into the inkwell";
    EXPECT_EQ(bench.arm(session->id).error().remedy, "put the stylus into the inkwell; then arm") << "as it says";
    bench.scripted[0]->calibrated = Calibration::kDone;
    EXPECT_TRUE(bench.arm(session->id).ok());
  }
}

TEST(Lease, WhereTheServoTakesNothingMoreNothingIsArmed) {
  Bench bench(Bench::relaxed(), 2);
  Session* session = bench.live();
  auto second = bench.core.openSession("test://second", bench.administration, "t", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(second.ok());
  ASSERT_TRUE(bench.core.sessions().mapped((*second)->id).ok());
  std::optional<ErrorCode> refused;
  int asked = 0;
  for (; !refused && asked < 1000; ++asked) {
    bench.core.arm(session->id, [&](const Result<void>& r) {
      if (!r) refused = r.error().code;
    });
  }
  ASSERT_TRUE(refused.has_value()) << "at once, not when the servo has had time";
  EXPECT_EQ(*refused, ErrorCode::kTimeout);
  EXPECT_LT(asked, 100);
  EXPECT_TRUE(bench.device().link->accepting()) << "edits are";
  std::optional<ErrorCode> other;
  bench.core.arm((*second)->id, [&](const Result<void>& r) { other = r ? ErrorCode::kOk : r.error().code; });
  bench.step(10);
  EXPECT_EQ(other, ErrorCode::kOk) << "another device is armed all the same";
  EXPECT_TRUE(bench.arm(session->id).ok());
}

TEST(Lease, ARefusedArmingLeavesItAsItWas) {
  Bench bench;
  Session* session = bench.live();
  const std::vector<std::pair<const char*, std::function<void(bool)>>> obstacles = {
      {"sleep", [&](bool stands) { bench.core.setAsleep(stands); }},
      {"not calibrated",
       [&](bool stands) { bench.scripted[0]->calibrated = stands ? Calibration::kNeeded : Calibration::kDone; }},
      {"a stop that is open", [&](bool stands) { bench.core.lines().stop.store(stands); }},
  };
  for (const auto& [what, set] : obstacles) {
    for (const bool held : {false, true}) {
      SCOPED_TRACE(std::string(what) + (held ? ", held before" : ""));
      if (held) {
        ASSERT_TRUE(bench.core.acquireLease(session->id).ok());
      }
      set(true);
      EXPECT_FALSE(bench.arm(session->id).ok());
      EXPECT_EQ(bench.device().lease, held ? session->id : 0u);
      set(false);
      bench.step();
      EXPECT_TRUE(bench.arm(session->id).ok());
      EXPECT_EQ(bench.device().lease, session->id);
      ASSERT_TRUE(bench.core.releaseLease(session->id).ok());
      bench.step(20);
    }
  }
  std::optional<Result<void>> late;  // No cycle comes that could answer.
  bench.core.arm(session->id, [&](Result<void> r) { late = std::move(r); });
  bench.clock.advance(2 * Core::kArmAnswerNs);
  bench.core.poll();
  ASSERT_TRUE(late && !late->ok());
  EXPECT_EQ(bench.device().lease, 0u);
  bench.step(20);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
}

TEST(Lease, NothingBeforeTheRegionsAreMapped) {
  Bench bench;
  auto session = bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok());
  EXPECT_FALSE(bench.core.acquireLease((*session)->id).ok());
  EXPECT_FALSE(bench.arm((*session)->id).ok());
}

TEST(Limits, HolderLowersAdministrationRaisesNobodyPassesTheDevice) {
  Bench bench;
  Session* session = bench.live();
  const GuardLimits before = bench.device().limits;
  GuardLimits lower = before;
  lower.force = before.force / 2;
  EXPECT_EQ(bench.core.setLimits("", lower, bench.connection).error().code, ErrorCode::kLeaseRequired);
  ASSERT_TRUE(bench.core.acquireLease(session->id).ok());
  ASSERT_TRUE(bench.core.setLimits("", lower, bench.connection).ok());
  EXPECT_EQ(bench.core.setLimits("", before, bench.connection).error().code, ErrorCode::kPermissionDenied);
  ASSERT_TRUE(bench.core.setLimits("", before, bench.administration).ok());
  GuardLimits beyond = before;
  beyond.force = bench.device().info().max_force;
  EXPECT_TRUE(bench.core.setLimits("", beyond, bench.administration).ok());
  beyond.force *= 1.01;
  const auto refused = bench.core.setLimits("", beyond, bench.administration);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(bench.device().limits.force, bench.device().info().max_force);
  EXPECT_EQ(bench.core.setLimits("test://nowhere", before, bench.administration).error().code, ErrorCode::kNotFound);
}

TEST(Limits, BadNumbersAreRefusedByNameAndNaNKeeps) {
  Bench bench;
  GuardLimits keep;
  for (double* x : {&keep.force, &keep.torque, &keep.force_slew, &keep.torque_slew, &keep.gripper_force, &keep.velocity,
                    &keep.power, &keep.active_power}) {
    *x = std::numeric_limits<double>::quiet_NaN();
  }
  const GuardLimits before = bench.device().limits;
  const auto same = bench.core.setLimits("", keep, bench.administration);
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->force, before.force);
  keep.velocity = -1;
  EXPECT_EQ(bench.core.setLimits("", keep, bench.administration).error().where, "limits.velocity");
  keep.velocity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(bench.core.setLimits("", keep, bench.administration).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(bench.device().limits.velocity, before.velocity);
}

TEST(Limits, TheServoObeysALoweredLimit) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(40);
  ASSERT_EQ(bench.client->push(Vec3(0, 3, 0)), ErrorCode::kOk);
  bench.step(60);
  EXPECT_NEAR(bench.sample().force[1], 3.0, 1e-3);
  GuardLimits limits = bench.device().limits;
  limits.force = 0.5;
  ASSERT_TRUE(bench.core.setLimits("", limits, bench.connection).ok());
  bench.step(3);
  EXPECT_LE(std::abs(bench.sample().force[1]), 0.5);
}

/** A force of 3 N, and a thousand edits that wait for the servo. */
class LimitsBehindEdits : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(bench.arm(session->id).ok());
    bench.step(40);
    ASSERT_EQ(bench.client->push(Vec3(0, 3, 0)), ErrorCode::kOk);
    bench.step(60);
    ASSERT_NEAR(force(), 3.0, 1e-3);
    limits = bench.device().limits;
  }
  void edit() {
    for (int i = 0; i < 1000; ++i) bench.device().applyRadius();
  }
  void set(double force) {
    limits.force = force;
    ASSERT_TRUE(bench.core.setLimits("", limits, bench.administration).ok());
  }
  double force() { return std::abs(bench.sample().force[1]); }
  double mostIn(int ticks) {
    double most = 0;
    for (int i = 0; i < ticks; ++i) {
      EXPECT_EQ(bench.client->push(Vec3(0, 3, 0)), ErrorCode::kOk);
      bench.step();
      most = std::max(most, force());
    }
    return most;
  }
  Bench bench;
  Session* session = bench.live();
  GuardLimits limits;
};

TEST_F(LimitsBehindEdits, ALoweredOneComesAtOnce) {
  edit();
  set(0.5);
  bench.step(5);  // 64 orders in flight at 16 a cycle
  EXPECT_TRUE(bench.core.busy());
  EXPECT_LE(mostIn(100), 0.5);
}

TEST_F(LimitsBehindEdits, ARaisedOneInItsTurn) {
  set(0.5);
  bench.step(5);
  EXPECT_LE(mostIn(200), 0.5);
  edit();
  set(2);
  EXPECT_LE(mostIn(50), 0.5) << "the edits that were to come first have not";
  EXPECT_NEAR(mostIn(200), 2, 1e-3);
}

TEST_F(LimitsBehindEdits, ARaiseThatWaitsUndoesNoLowering) {
  set(0.5);
  bench.step(5);
  edit();
  set(2);
  edit();
  set(1);
  EXPECT_LE(mostIn(50), 0.5) << "a lowering raises nothing";
  EXPECT_LE(mostIn(300), 1.0);
  EXPECT_NEAR(force(), 1.0, 1e-3);
}

TEST_F(LimitsBehindEdits, WhatIsRaisedHoldsBackNothingThatIsLowered) {
  edit();
  limits.velocity /= 2;
  set(0.5);
  limits.velocity *= 1.5;
  set(0.4);
  bench.step(5);
  EXPECT_LE(mostIn(100), 0.4);
  EXPECT_EQ(bench.device().limits.velocity, limits.velocity);
}

TEST_F(LimitsBehindEdits, WhereNothingMoreIsTakenALoweringStillIs) {
  while (bench.device().link->accepting()) edit();
  EXPECT_FALSE(bench.device().link->accepting());
  limits.force *= 1.5;
  const auto raised = bench.core.setLimits("", limits, bench.administration);
  EXPECT_EQ(raised.error().code, ErrorCode::kTimeout);
  EXPECT_LT(bench.device().limits.force, limits.force) << "refused, nothing is changed";
  set(0.5);
  bench.step(5);
  EXPECT_LE(force(), 0.5);
}

TEST(Limits, LoweringOneDeviceLeavesTheRaiseOfAnotherThatWaits) {
  Bench bench(Bench::relaxed(), 2);
  const auto set = [&](const char* device, double force) {
    GuardLimits limits = bench.device().limits;
    limits.force = force;
    ASSERT_TRUE(bench.core.setLimits(device, limits, bench.administration).ok());
  };
  const auto inForce = [&](std::uint32_t device) {
    return bench.device().link->group().servo().cycle().deviceGuard(device).limits().force;
  };
  set("test://first", 2);
  set("test://second", 1);
  bench.step(5);
  ASSERT_EQ(inForce(1), 1);
  for (int i = 0; i < 1000; ++i) bench.device().applyRadius();
  set("test://second", 3);
  set("test://first", 0.5);
  bench.step(10);
  EXPECT_EQ(inForce(0), 0.5);
  EXPECT_EQ(inForce(1), 1) << "its turn has not come";
  bench.step(100);
  EXPECT_EQ(inForce(0), 0.5);
  EXPECT_EQ(inForce(1), 3);
}

/** Thousands of lowerings in one breath leave the servo room for a stop. */
TEST_F(LimitsBehindEdits, AFloodOfLoweringsKeepsRoomForAStop) {
  bool refused = false;
  for (int i = 0; i < 2000 && !refused; ++i) {
    limits.force *= 0.999;
    const auto lowered = bench.core.setLimits("", limits, bench.administration);
    refused = !lowered.ok();
    EXPECT_TRUE(lowered.ok() || lowered.error().code == ErrorCode::kTimeout);
  }
  EXPECT_TRUE(refused);
  ASSERT_TRUE(bench.core.stop("", bench.connection).ok());
  bench.step(10);
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_STOP_LINE));
  EXPECT_TRUE(bench.core.setLimits("", limits, bench.administration).ok());
}

}  // namespace
}  // namespace hapticd::test
