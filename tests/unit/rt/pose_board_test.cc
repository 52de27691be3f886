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

TEST(PoseBoard, ASlotThatIsFreedAndTakenAgainShowsWhatIsThereNow) {
  const auto table = std::make_unique<MeshTable>();
  const auto scene = std::make_unique<Scene>(*table);
  const auto board = std::make_unique<PoseBoard>();
  std::uint64_t tick = 0;
  const auto turn = [&] {
    for (std::uint32_t i = 0; i < kMaxObjects; i += PoseBoard::kPerCycle) board->publish(*scene, ++tick, 0);
  };
  const auto add = [&](std::uint32_t generation, double stiffness, double x) {
    Command command;
    command.kind = CommandKind::kAddObject;
    auto& object = command.as<AddObject>();
    object = AddObject{};
    object.object = makeObjectId(1, generation);
    object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kSphere);
    object.shape.size[0] = 0.01;
    object.material.stiffness = stiffness;
    object.p[0] = x;
    object.q[0] = 1;
    ASSERT_EQ(scene->apply(command), ErrorCode::kOk);
  };
  PosedObject posed;
  add(1, 500, 0.1);
  turn();
  ASSERT_TRUE(board->read(1, posed));
  EXPECT_EQ(posed.object, makeObjectId(1, 1));
  EXPECT_EQ(posed.material.stiffness, 500);
  EXPECT_EQ(posed.p_PO[0], 0.1);
  Command remove;
  remove.kind = CommandKind::kRemoveObject;
  remove.as<ObjectRef>() = {makeObjectId(1, 1)};
  ASSERT_EQ(scene->apply(remove), ErrorCode::kOk);
  turn();
  ASSERT_TRUE(board->read(1, posed));
  EXPECT_EQ(posed.object, 0u);
  add(2, 700, 0.2);
  turn();
  ASSERT_TRUE(board->read(1, posed));
  EXPECT_EQ(posed.object, makeObjectId(1, 2));
  EXPECT_EQ(posed.material.stiffness, 700);
  EXPECT_EQ(posed.p_PO[0], 0.2);
}

}  // namespace
}  // namespace hapticd
