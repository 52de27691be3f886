// Emergency stop, dead-man switch and buttons of the machine reach every servo, and servos show that they live.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

class MachineLines : public testing::Test {
 protected:
  MachineLines() {
    session = bench.live();
    EXPECT_TRUE(bench.arm(session->id).ok());
    bench.step(50);
    EXPECT_TRUE(bench.scripted[0]->sent.back().enabled);
  }
  Bench bench;
  SafetyLines& lines = bench.core.lines();
  Session* session = nullptr;
};

TEST_F(MachineLines, AnOpenStopIsZeroInTheNextTickAndLatches) {
  lines.stop = true;
  bench.step(1);
  EXPECT_FALSE(bench.scripted[0]->sent.back().enabled);
  EXPECT_EQ(bench.sample().fault, HD_FAULT_STOP_LINE);
  EXPECT_EQ(bench.arm(session->id).error().code, ErrorCode::kFaultLatched);
  lines.stop = false;
  bench.step(50);
  EXPECT_EQ(bench.sample().fault, HD_FAULT_STOP_LINE) << "closing it arms nothing";
  EXPECT_TRUE(bench.arm(session->id).ok());
}

TEST_F(MachineLines, ADeadmanThatIsLetGoIsAFault) {
  lines.deadman_open = true;
  bench.step(1);
  EXPECT_FALSE(bench.scripted[0]->sent.back().enabled);
  EXPECT_EQ(bench.sample().fault, HD_FAULT_DEADMAN);
}

TEST_F(MachineLines, APanelThatNoLongerLooksIsAStop) {
  lines.looked_ns = bench.clock.now();
  bench.step(SafetyLines::kDeaf_ns / kMs);
  EXPECT_EQ(bench.sample().fault, HD_FAULT_NONE);
  bench.step(2);
  EXPECT_EQ(bench.sample().fault, HD_FAULT_STOP_LINE);
}

TEST_F(MachineLines, ButtonsFollowTheDevicesOwn) {
  const std::uint32_t own = bench.device().info().buttons;
  lines.button_count = 2;
  lines.buttons = 2;
  bench.step(1);
  EXPECT_EQ(bench.sample().buttons >> own, 2u);
  lines.buttons = 1;
  bench.step(1);
  EXPECT_EQ(bench.sample().buttons >> own, 1u);
  lines.buttons = 0;
  bench.step(1);
  EXPECT_EQ(bench.sample().buttons >> own, 0u);
}

TEST_F(MachineLines, AServoShowsThatItLivesAndWhetherItsAmplifiersAreOn) {
  const SafetyLines::Sign& sign = lines.servos[0];
  EXPECT_TRUE(sign.used);
  EXPECT_TRUE(sign.enabled);
  const std::uint64_t before = sign.cycles;
  bench.step(7);
  EXPECT_EQ(sign.cycles, before + 7);
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  bench.step(20);
  EXPECT_FALSE(sign.enabled);
  ASSERT_TRUE(bench.core.devices().endServo(*bench.core.devices().links().front()).ok());
  EXPECT_FALSE(sign.used) << "with its servo, whatever of its group is left";
}

}  // namespace
}  // namespace hapticd::test
