// Commands sent ahead: each takes effect in its own tick, in the order they came, and none outlives its sender.
#include <gtest/gtest.h>

#include <vector>

#include "rt/ingest/limits.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

class PendingCommands : public testing::Test, protected test::SteppedCycle {
 protected:
  PendingCommands() {
    input->device[0].fresh = true;
    session(CommandKind::kAddSession);
    session(CommandKind::kLoseSession);
    session(CommandKind::kFreeSession);
    session(CommandKind::kAddSession);
    step();
  }
  void session(CommandKind kind) { put(kind, SessionRef{kSlot, 0, 7}); }
  void sendAhead(std::uint64_t at_tick, std::uint64_t seq) {
    Command& command = put(CommandKind::kLimits, hd_limits{1, 1}, kSlot);
    command.seq = seq;
    command.at_tick = at_tick;
  }
  /** As many as the cycle keeps, in as many ticks as they need. */
  void fill(std::uint64_t at_tick) {
    for (std::uint32_t sent = 0; sent < kMost; ++sent) {
      if (input->command_count == kMaxCommandsPerCycle) step();
      sendAhead(at_tick, sent + 1);
    }
    step();
  }
  void step() {
    SteppedCycle::step();
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      const ServoEvent& event = output->events.event[i];
      if (event.kind != ServoEventKind::kCommandRefused) continue;
      EXPECT_EQ(event.value, static_cast<std::uint32_t>(ErrorCode::kQuotaExceeded));
      EXPECT_EQ(event.session, kSlot);
      EXPECT_EQ(event.tick, input->tick);
      ++refused;
    }
    refused += output->events.dropped;
  }
  std::uint64_t applied() const { return cycle->session(kSlot).appliedSeq(); }

  static constexpr std::uint32_t kSlot = 2, kMost = limits::kWaitingPerSession * kMaxSessions;
  std::uint32_t refused = 0;
};

TEST_F(PendingCommands, TakeEffectInTheirTick) {
  sendAhead(4, 1);
  sendAhead(3, 2);
  step();
  EXPECT_EQ(applied(), 0u);
  step();
  EXPECT_EQ(applied(), 2u);
  step();
  EXPECT_EQ(applied(), 1u);
}

TEST_F(PendingCommands, AreAppliedOnceEachInTheOrderTheyCame) {
  forSeeds(20, [&](unsigned seed) {
    Random random(seed);
    const std::uint64_t begin = input->tick;
    std::vector<std::vector<std::uint64_t>> due(60);  // Numbers, by tick from `begin` on.
    std::uint64_t last = applied();
    for (std::uint64_t tick = 1, seq = 1; tick < due.size(); ++tick) {
      for (int i = random.below(8); i > 0 && tick < 40; --i, ++seq) {
        const std::uint64_t at = tick - 1 + random.below(15u);  // The past is at once.
        sendAhead(begin + at, seq);
        due[std::max(tick, at)].push_back(seq);
      }
      step();
      ASSERT_EQ(output->applied_commands, due[tick].size()) << tick;
      if (!due[tick].empty()) last = due[tick].back();
      ASSERT_EQ(applied(), last) << tick;
      if (!due[tick].empty()) {
        ASSERT_EQ(cycle->session(kSlot).appliedTick(), begin + tick);
      }
    }
    ASSERT_TRUE(cycle->pending().empty());
  });
  EXPECT_EQ(refused, 0u);
}

TEST_F(PendingCommands, AllThatSessionsMaySendAheadIsKeptAndNoMore) {
  fill(50);
  EXPECT_EQ(refused, 0u);
  EXPECT_EQ(cycle->pending().size(), kMost);
  for (int i = 0; i < 3; ++i) sendAhead(50, 1000);
  step();
  EXPECT_EQ(refused, 3u);
  while (input->tick < 49) step();
  EXPECT_EQ(applied(), 0u);
  step();
  EXPECT_EQ(output->applied_commands, kMost);
  EXPECT_EQ(applied(), kMost);
}

TEST_F(PendingCommands, EndWithTheirSender) {
  sendAhead(6, 9);
  step();
  session(CommandKind::kFreeSession);
  step();
  session(CommandKind::kAddSession);
  for (int i = 0; i < 10; ++i) {
    step();
    EXPECT_EQ(applied(), 0u) << "the slot's next owner never sent it";
  }
}

TEST_F(PendingCommands, OfOthersOutliveIt) {
  sendAhead(6, 9);
  put(CommandKind::kAddSession, SessionRef{kSlot + 1, 0, 8});
  step();
  put(CommandKind::kFreeSession, SessionRef{kSlot + 1, 0, 8});
  while (input->tick < 6) step();
  EXPECT_EQ(applied(), 9u);
}

TEST_F(PendingCommands, OfASenderThatIsGoneLeaveRoomForOthers) {
  fill(1000);
  session(CommandKind::kFreeSession);
  step();
  session(CommandKind::kAddSession);
  fill(50);
  EXPECT_EQ(refused, 0u);
  while (input->tick < 50) step();
  EXPECT_EQ(applied(), kMost);
}

}  // namespace
}  // namespace hapticd
