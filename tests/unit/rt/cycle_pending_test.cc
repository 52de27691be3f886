// Commands sent ahead: each takes effect in its own tick, and none outlives its sender.
#include <gtest/gtest.h>

#include <memory>

#include "rt/cycle/cycle.h"

namespace hapticd {
namespace {

class PendingCommands : public testing::Test {
 protected:
  PendingCommands() {
    input->device[0].fresh = true;
    session(CommandKind::kAddSession);
    session(CommandKind::kLoseSession);
    session(CommandKind::kFreeSession);
    session(CommandKind::kAddSession);
    step();
  }
  void session(CommandKind kind) {
    Command& order = input->command[input->command_count++] = Command{};
    order.kind = kind;
    order.as<SessionRef>() = {kSlot, 0, 7};
  }
  void sendAhead(std::uint64_t at_tick, std::uint64_t seq) {
    Command& command = input->command[input->command_count++] = Command{};
    command.kind = CommandKind::kLimits;
    command.session = kSlot;
    command.seq = seq;
    command.at_tick = at_tick;
    command.as<hd_limits>() = {1, 1};
  }
  void step() {
    ++input->tick;
    input->now_ns += 1'000'000;
    cycle->step(*input, *output);
    input->command_count = 0;
  }
  std::uint64_t applied() const { return cycle->session(kSlot).appliedSeq(); }

  static constexpr std::uint32_t kSlot = 2;
  MeshTable meshes;
  std::unique_ptr<Cycle> cycle = std::make_unique<Cycle>(CycleConfig{}, meshes);
  std::unique_ptr<CycleInput> input = std::make_unique<CycleInput>();
  std::unique_ptr<CycleOutput> output = std::make_unique<CycleOutput>();
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

}  // namespace
}  // namespace hapticd
