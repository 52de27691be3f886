// Stop orders, and orders to arm that are called off, stepped by hand.
#include <optional>

#include "tests/session/bench.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

TEST(Stop, AnybodyStopsAndItLatchesUntilArmedAgain) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(20);
  const std::uint64_t stranger = *bench.core.connect(9, 4711, false);
  ASSERT_TRUE(bench.core.stop("", stranger).ok());
  bench.step(2);
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_STOP_LINE));
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  bench.step(100);
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_STOP_LINE)) << "it stays";
  ASSERT_TRUE(bench.arm(session->id).ok());
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_NONE));
  EXPECT_EQ(bench.core.stop("test://nowhere", stranger).error().code, ErrorCode::kNotFound);
}

TEST(Stop, OfOneDeviceIsNotOfTheOthersAndOfNoneIsOfAll) {
  for (const bool all : {false, true}) {
    Bench bench(Bench::relaxed(), 2);
    ASSERT_TRUE(bench.core.stop(all ? "" : "test://second", bench.connection).ok());
    bench.step(2);
    for (std::uint32_t device = 0; device < 2; ++device) {
      hd_sample s{};
      ASSERT_TRUE(bench.core.devices().links().front()->latest(device, s));
      EXPECT_EQ(s.fault, static_cast<std::uint32_t>(all || device == 1 ? HD_FAULT_STOP_LINE : HD_FAULT_NONE));
    }
  }
}

TEST(Stop, WhereTheServoTakesNothingMoreTheDeviceIsMadeSafeWithoutIt) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  ASSERT_TRUE(bench.core.stop("", bench.connection).ok());
  EXPECT_FALSE(bench.scripted[0]->safed) << "the servo will do it";
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(bench.core.stop("", bench.connection).ok());  // No cycle comes.
  bench.clock.advance(Core::kOffTaken_ns - 1);
  bench.core.poll();
  EXPECT_FALSE(bench.scripted[0]->safed);
  bench.clock.advance(1);
  bench.core.poll();
  EXPECT_TRUE(bench.scripted[0]->safed);
  bench.scripted[0]->safed = false;
  bench.core.poll();
  EXPECT_FALSE(bench.scripted[0]->safed) << "once is enough";
  bench.step(2);
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_STOP_LINE)) << "should it come back";
}

TEST(Stop, AFloodOfThemLeavesRoomForTheOthers) {
  Bench bench(Bench::relaxed(), 2);
  ObjectSpec spec;
  spec.name = "plate";
  spec.material = kDefaultMaterial;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_TRUE(bench.core.stop("test://first", bench.connection).ok());
    if (i == 1000) {
      ASSERT_TRUE(bench.core.scene().create(spec, bench.core.client(bench.connection)).ok());
    }
  }
  ASSERT_TRUE(bench.core.stop("test://second", bench.connection).ok());
  bench.step(1);
  hd_sample other{};
  ASSERT_TRUE(bench.core.devices().links().front()->latest(1, other));
  EXPECT_EQ(other.fault, HD_FAULT_STOP_LINE);
  EXPECT_TRUE(bench.core.scene().find("plate").ok());
  EXPECT_FALSE(bench.core.busy()) << "nor does anybody's edit wait behind them";
}

/** Whatever is said, and however much of it at once, the last word is what the device does. */
TEST(Stop, TheLastWordStandsInAnyOrder) {
  Random random(seedOf(29));
  Bench bench;
  Session* const session = bench.live();
  ASSERT_TRUE(bench.core.acquireLease(session->id).ok());
  for (int round = 0; round < 300; ++round) {
    bool armed = false, stopped = false;
    bench.core.arm(session->id, [](const Result<void>&) {});  // Clears what the last round has left.
    bench.step(20);
    for (int i = 0; i < 12; ++i) {
      switch (random.below(6)) {
        case 0:
        case 1:
          ASSERT_TRUE(bench.core.stop("", bench.connection).ok());
          armed = false;
          stopped = true;
          break;
        case 2:
          ASSERT_TRUE(bench.core.disarm(session->id).ok());
          armed = false;
          break;
        case 3:
          bench.core.arm(session->id, [](const Result<void>&) {});
          armed = true;
          stopped = false;
          break;
        case 4:
          for (int n = 0; n < 40; ++n) bench.device().applyRadius();  // Orders that the next ones wait behind.
          break;
        default:
          bench.step(1);
      }
    }
    if (!armed) {
      ASSERT_TRUE(bench.core.disarm(session->id).ok());
    }
    bench.step(80);
    EXPECT_EQ((bench.sample().flags & HD_SAMPLE_ARMED) != 0, armed) << "round " << round;
    if (armed) {
      EXPECT_EQ(bench.sample().fault, HD_FAULT_NONE) << "round " << round;
    }
    if (stopped) {
      EXPECT_EQ(bench.sample().fault, HD_FAULT_STOP_LINE) << "round " << round;
    }
  }
}

TEST(Stop, OvertakesAThousandEditsThatWait) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  ObjectSpec spec;
  spec.name = "busy";
  spec.material = kDefaultMaterial;
  ASSERT_TRUE(bench.core.scene().create(spec, bench.core.client(bench.connection)).ok());
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(bench.core.scene().setPose("busy", Pose{}).ok());
  ASSERT_TRUE(bench.core.stop("", bench.connection).ok());
  bench.step(5);  // 64 orders in flight at 16 a cycle
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_STOP_LINE));
  EXPECT_TRUE(bench.core.busy());
}

/** An order to arm that still waits behind a thousand edits when it is called off. */
class ArmThatWaits : public testing::Test {
 protected:
  ArmThatWaits() {
    for (int i = 0; i < 1000; ++i) bench.device().applyRadius();
    bench.core.arm(session->id, [this](Result<void> r) { outcome = std::move(r); });
  }
  void expectOff() {
    bench.step(200);
    EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  }
  Bench bench;
  Session* session = bench.live();
  std::optional<Result<void>> outcome;
};

TEST_F(ArmThatWaits, IsCalledOffByAStop) {
  ASSERT_TRUE(bench.core.stop("", bench.connection).ok());
  expectOff();
  EXPECT_EQ(bench.sample().fault, static_cast<std::uint32_t>(HD_FAULT_STOP_LINE));
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->error().code, ErrorCode::kFaultLatched);
  EXPECT_TRUE(bench.arm(session->id).ok()) << "armed again it goes on";
}

TEST_F(ArmThatWaits, IsCalledOffByItsHoldersDisarm) {
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  expectOff();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->error().code, ErrorCode::kCancelled) << "it is not armed, and must not be told so";
  EXPECT_EQ(bench.device().lease, 0u) << "the order had taken it";
}

TEST_F(ArmThatWaits, LeavesTheLeaseWithWhoHeldItBefore) {
  bench.step(200);
  ASSERT_TRUE(outcome.has_value() && outcome->ok()) << "the first has come through";
  outcome.reset();
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  bench.step(100);
  for (int i = 0; i < 1000; ++i) bench.device().applyRadius();
  bench.core.arm(session->id, [this](Result<void> r) { outcome = std::move(r); });
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  bench.step(200);
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->error().code, ErrorCode::kCancelled);
  EXPECT_EQ(bench.device().lease, session->id);
}

TEST_F(ArmThatWaits, LeavesTheLeaseToAnOrderThatFollows) {
  for (const bool that_too : {false, true}) {
    std::optional<Result<void>> first, second;
    const auto into = [](auto& outcome) { return [&outcome](Result<void> r) { outcome = std::move(r); }; };
    bench.core.arm(session->id, into(first));
    ASSERT_TRUE(bench.core.disarm(session->id).ok());
    for (int i = 0; i < 100; ++i) bench.device().applyRadius();  // The first is answered before.
    bench.core.arm(session->id, into(second));
    if (that_too) {
      ASSERT_TRUE(bench.core.disarm(session->id).ok());
    }
    bench.step(200);
    ASSERT_TRUE(first.has_value() && second.has_value());
    EXPECT_EQ(first->error().code, ErrorCode::kCancelled);
    EXPECT_EQ(second->ok(), !that_too);
    EXPECT_EQ(bench.device().lease, that_too ? 0 : session->id);
    if (!that_too) {
      ASSERT_TRUE(bench.core.releaseLease(session->id).ok());
    }
    expectOff();
  }
}

TEST_F(ArmThatWaits, IsCalledOffByTheReleaseOfItsLease) {
  ASSERT_TRUE(bench.core.releaseLease(session->id).ok());
  expectOff();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->error().code, ErrorCode::kLeaseRequired) << "it is not armed, and must not be told so";
}

TEST_F(ArmThatWaits, IsCalledOffByItsHoldersDeath) {
  bench.core.disconnect(bench.connection);
  expectOff();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_FALSE(outcome->ok());
}

TEST_F(ArmThatWaits, TooLongIsCalledOff) {
  bench.clock.advance(Core::kArmAnswerNs + kMs);
  bench.core.poll();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->error().code, ErrorCode::kTimeout);
  expectOff();
  EXPECT_TRUE(bench.arm(session->id).ok());
}

TEST_F(ArmThatWaits, TooLongCallsOffNobodyElses) {
  auto second = bench.core.openSession("", bench.connection, "second", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(second.ok());
  const ClientSide client(**second);
  ASSERT_TRUE(bench.core.sessions().mapped((*second)->id).ok());
  ASSERT_TRUE(bench.core.releaseLease(session->id).ok());
  bench.clock.advance(Core::kArmAnswerNs / 2);
  std::optional<Result<void>> others;
  bench.core.arm((*second)->id, [&](Result<void> r) { others = std::move(r); });
  bench.clock.advance(Core::kArmAnswerNs / 2 + kMs);
  bench.core.poll();
  ASSERT_TRUE(outcome.has_value());
  EXPECT_EQ(outcome->error().code, ErrorCode::kTimeout);
  for (int i = 0; i < 80; ++i) {
    client.producer->heartbeat(bench.clock.now());
    bench.step();
  }
  ASSERT_TRUE(others.has_value());
  EXPECT_TRUE(others->ok());
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
}

TEST_F(ArmThatWaits, IsCalledOffByTheEndOfTheDaemon) {
  bench.core.beginShutdown();
  expectOff();
}

TEST(Stop, ArmingWhileTheCauseStandsIsRefusedWithTheCause) {
  Bench bench;
  Session* session = bench.live();
  bench.core.devices().links().front()->group().servo().stop_line.store(true);
  bench.step(2);
  const auto refused = bench.arm(session->id);
  EXPECT_EQ(refused.error().code, ErrorCode::kFaultLatched);
  EXPECT_NE(refused.error().what.find("emergency stop"), std::string::npos);
}

}  // namespace
}  // namespace hapticd::test
