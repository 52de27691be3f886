#include "rt/cycle/pose_board.h"

#include <gtest/gtest.h>

#include <memory>

namespace hapticd {
namespace {

TEST(PoseBoard, EverySlotIsFreshAfterItsTurnAndSaysWhen) {
  const auto table = std::make_unique<MeshTable>();
  const auto scene = std::make_unique<Scene>(*table);
  const auto board = std::make_unique<PoseBoard>();
  PosedObject posed;
  ASSERT_TRUE(board->read(3, posed));
  EXPECT_EQ(posed.tick, 0u);
  constexpr std::uint64_t kRound = kMaxObjects / PoseBoard::kPerCycle;
  for (std::uint64_t tick = 1; tick <= 2 * kRound; ++tick) {
    board->publish(*scene, tick, static_cast<std::uint32_t>(7 * tick));
  }
  for (std::uint32_t slot = 0; slot < kMaxObjects; ++slot) {
    ASSERT_TRUE(board->read(slot, posed));
    EXPECT_EQ(posed.tick, kRound + 1 + slot / PoseBoard::kPerCycle);
    EXPECT_EQ(posed.control_applied, 7 * posed.tick);
    EXPECT_EQ(posed.object, 0u);
  }
}

}  // namespace
}  // namespace hapticd
