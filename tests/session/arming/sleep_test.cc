// A machine that goes to sleep: nothing may keep its force meanwhile.
#include "daemon/main/sleep_watch.h"
#include "tests/session/bench.h"
#include "tests/support/process/fake_logind.h"

namespace hapticd::test {
namespace {

class Sleep : public testing::Test {
 protected:
  Sleep() : session(bench.live()) { step(2); }

  void step(int periods) {
    for (int i = 0; i < periods; ++i) {
      bench.step();
      logind.step();
      watch.step();
      logind.step();
    }
  }
  void tell(bool asleep) {
    logind.prepareForSleep(asleep);
    step(1);
  }
  void arm() {
    ASSERT_TRUE(bench.arm(session->id).ok());
    step(20);
    ASSERT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  }
  std::uint32_t fault() { return bench.sample().fault; }

  FakeLogind logind;
  Bench bench;
  Session* session;
  int opened = 0;
  SleepWatch watch{bench.core, [this](sd_bus** bus) {
                     ++opened;
                     return logind.open(bus);
                   }};
};

TEST_F(Sleep, IsHeldUpUntilWhatWasArmedIsOff) {
  EXPECT_EQ(logind.asked, "sleep by hapticd, delay");
  EXPECT_TRUE(logind.held());
  arm();
  step(1000);
  EXPECT_TRUE(logind.held());
  tell(true);
  step(1);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(fault(), static_cast<std::uint32_t>(HD_FAULT_STOP_LINE));
  EXPECT_TRUE(logind.held()) << "its driver may be a bit behind";
  step(120);
  EXPECT_FALSE(logind.held());
}

TEST_F(Sleep, NothingIsArmedUntilTheMachineIsAwake) {
  arm();
  tell(true);
  step(120);
  const auto refused = bench.arm(session->id);
  EXPECT_EQ(refused.error().code, ErrorCode::kWouldBlock);
  EXPECT_NE(refused.error().what.find("sleep"), std::string::npos);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_FALSE(logind.held());
  tell(false);
  step(2);
  EXPECT_EQ(logind.locks, 2);
  EXPECT_TRUE(logind.held()) << "for the next time";
  step(100);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u) << "by itself nothing comes back";
  arm();
  EXPECT_EQ(fault(), static_cast<std::uint32_t>(HD_FAULT_NONE));
  tell(true);
  step(120);
  EXPECT_FALSE(logind.held());
}

TEST_F(Sleep, WithNothingArmedIsNotHeldUp) {
  tell(true);
  step(1);
  EXPECT_FALSE(logind.held());
  EXPECT_EQ(fault(), static_cast<std::uint32_t>(HD_FAULT_NONE));
  EXPECT_EQ(bench.arm(session->id).error().code, ErrorCode::kWouldBlock);
}

TEST_F(Sleep, IsHeldUpAsLongAsADriverHasNotSentTheZeros) {
  arm();
  bench.scripted[0]->hung = true;
  tell(true);
  step(1000);
  EXPECT_TRUE(logind.held()) << "logind knows when it has waited long enough";
  bench.scripted[0]->hung = false;
  step(120);
  EXPECT_FALSE(logind.held());
}

TEST_F(Sleep, WhoIsToldByAStrangerGoesOn) {
  arm();
  logind.prepareForSleep(true, "org.freedesktop.login2");
  step(10);
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
}

TEST_F(Sleep, WithoutALockDevicesAreStoppedStill) {
  logind.leave();
  step(1);
  logind.refuses = true;
  bench.clock.advance(SleepWatch::kAgain_ns);
  step(4);
  EXPECT_EQ(opened, 2);
  EXPECT_EQ(logind.locks, 1);
  EXPECT_FALSE(watch.holds());
  arm();
  tell(true);
  step(1);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  tell(false);
  logind.refuses = false;
  bench.clock.advance(SleepWatch::kAgain_ns);
  step(4);
  EXPECT_TRUE(logind.held()) << "asked again";
}

/** Nobody would say that the machine is awake. */
TEST_F(Sleep, ALogindThatGoesLeavesNobodyAsleep) {
  tell(true);
  logind.leave();
  step(2);
  EXPECT_FALSE(watch.holds());
  arm();
  EXPECT_EQ(opened, 1) << "not asked at every step";
  bench.clock.advance(SleepWatch::kAgain_ns);
  step(4);
  EXPECT_EQ(opened, 2);
  EXPECT_TRUE(logind.held());
}

/** A logind that is started anew does not know what the one before has said. */
TEST_F(Sleep, OfWhichNothingMoreIsHeardIsOver) {
  tell(true);
  step(2);
  bench.clock.advance(SleepWatch::kFallingAsleep_ns);
  step(4);
  EXPECT_TRUE(logind.held());
  arm();
}

TEST(SleepWithoutABus, IsNoTrouble) {
  Bench bench;
  int asked = 0;
  SleepWatch watch(bench.core, [&](sd_bus**) {
    ++asked;
    return -ENOENT;
  });
  for (int i = 0; i < 100; ++i) watch.step();
  EXPECT_EQ(asked, 1);
  bench.clock.advance(SleepWatch::kAgain_ns);
  watch.step();
  EXPECT_EQ(asked, 2);
  EXPECT_TRUE(bench.arm(bench.live()->id).ok());
}

}  // namespace
}  // namespace hapticd::test
