#include "rt/cycle/pose_board.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/stepped/solid.h"

namespace hapticd {
namespace {

class PoseBoardOf : public ::testing::Test {
 protected:
  void add(std::uint32_t slot, std::uint32_t generation, double stiffness, double x) {
    const AddObject ball = test::solid(makeObjectId(slot, generation), ShapeKind::kSphere, {stiffness, 0, 0, 0},
                                       {{x, 0, 0}, Quat::Identity()}, {0.01, 0, 0});
    ASSERT_EQ(scene_->apply(makeCommand(CommandKind::kAddObject, ball)), ErrorCode::kOk);
  }
  void remove(std::uint32_t slot, std::uint32_t generation) {
    const ObjectRef ball{makeObjectId(slot, generation)};
    ASSERT_EQ(scene_->apply(makeCommand(CommandKind::kRemoveObject, ball)), ErrorCode::kOk);
  }
  void publish() {
    ++tick_;
    board_->publish(*scene_, tick_, static_cast<std::uint32_t>(7 * tick_));
  }
  PosedObject read(std::uint32_t slot) {
    PosedObject posed;
    EXPECT_TRUE(board_->read(slot, posed));
    return posed;
  }

  std::uint64_t tick_ = 0;
  std::unique_ptr<MeshTable> table_ = std::make_unique<MeshTable>();
  std::unique_ptr<Scene> scene_ = std::make_unique<Scene>(*table_);
  std::unique_ptr<PoseBoard> board_ = std::make_unique<PoseBoard>();
};

TEST_F(PoseBoardOf, AFewObjectsIsFreshEachCycle) {
  for (const std::uint32_t slot : {3u, 200u, 5u}) add(slot, 1, 500, 0.1 * slot);
  for (int i = 0; i < 10; ++i) {
    publish();
    for (const std::uint32_t slot : {3u, 200u, 5u}) {
      const PosedObject posed = read(slot);
      EXPECT_EQ(posed.object, makeObjectId(slot, 1));
      EXPECT_EQ(posed.p_PO[0], 0.1 * slot);
      EXPECT_EQ(posed.tick, tick_);
      EXPECT_EQ(posed.control_applied, 7 * tick_);
    }
    EXPECT_EQ(read(4).object, 0u);
  }
}

TEST_F(PoseBoardOf, AnObjectIsShownWithAllThatIsKnownOfIt) {
  add(7, 1, 500, 0.1);
  hd_object_pose pose{};
  pose.object = makeObjectId(7, 1);
  store(Vec3(0.1, -0.2, 0.3), pose.p);
  store(Quat(0.5, 0.5, -0.5, 0.5), pose.q);
  store(Vec3(1, 2, 3), pose.v);
  store(Vec3(4, 5, 6), pose.w);
  Command command = makeCommand(CommandKind::kObjectPose, pose, 1);
  ASSERT_EQ(scene_->apply(command), ErrorCode::kOk);
  const hd_object_flags flags{makeObjectId(7, 1), HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE, HD_OBJECT_VISIBLE, 0};
  ASSERT_EQ(scene_->apply(makeCommand(CommandKind::kObjectFlags, flags, 1)), ErrorCode::kOk);
  scene_->advance(1e-3);
  publish();
  const SceneObject* const object = scene_->find(makeObjectId(7, 1));
  ASSERT_NE(object, nullptr);
  const PosedObject posed = read(7);
  EXPECT_EQ(posed.flags, std::uint32_t{HD_OBJECT_VISIBLE});
  EXPECT_EQ(posed.client_edits, object->client_edits);
  EXPECT_NE(posed.client_edits, PosedObject{}.client_edits) << "of what a client has edited";
  EXPECT_EQ(posed.material.stiffness, 500);
  EXPECT_EQ(vec3(posed.p_PO), Vec3(0.1, -0.2, 0.3));
  EXPECT_EQ(vec3(posed.v_PO), Vec3(1, 2, 3));
  EXPECT_EQ(vec3(posed.w_PO), Vec3(4, 5, 6));
  EXPECT_EQ(vec3(posed.p_WO), object->X_WO.p);
  EXPECT_EQ(quat(posed.q_PO).coeffs(), object->X_PO.q.coeffs());
  EXPECT_GT(quat(posed.q_PO).angularDistance(Quat::Identity()), 1);
  EXPECT_EQ(quat(posed.q_WO).coeffs(), object->X_WO.q.coeffs());
}

TEST_F(PoseBoardOf, AFullSceneGivesEachObjectItsTurn) {
  for (std::uint32_t slot = 1; slot < kMaxObjects; ++slot) add(slot, 1, 500, 0);
  constexpr std::uint64_t kRound = kMaxObjects / PoseBoard::kPerCycle;
  for (std::uint64_t i = 0; i < 5 * kRound; ++i) {
    publish();
    if (i < kRound) continue;
    for (std::uint32_t slot = 1; slot < kMaxObjects; ++slot) {
      const PosedObject posed = read(slot);
      ASSERT_GT(posed.tick + kRound, tick_) << slot;
      ASSERT_EQ(posed.control_applied, 7 * posed.tick);
    }
  }
}

TEST_F(PoseBoardOf, AnObjectWaitsTwoRoundsAtMostWhileOthersGo) {
  constexpr std::uint32_t kCount = 160;
  for (std::uint32_t slot = 1; slot <= kCount; ++slot) add(slot, 1, 500, 0);
  for (std::uint32_t gone = 1; gone < kCount; ++gone) {
    publish();
    remove(gone, 1);
    if (gone < 20) continue;
    for (std::uint32_t slot = gone + 1; slot <= kCount; ++slot)
      ASSERT_GE(read(slot).tick + 2 * kCount / PoseBoard::kPerCycle, tick_) << slot;
  }
}

TEST_F(PoseBoardOf, ASlotTakenAgainShowsWhatIsThereNow) {
  add(1, 1, 500, 0.1);
  publish();
  EXPECT_EQ(read(1).material.stiffness, 500);
  remove(1, 1);
  publish();
  EXPECT_EQ(read(1).tick, 1u) << "as it was at last";
  add(1, 2, 700, 0.2);
  publish();
  const PosedObject posed = read(1);
  EXPECT_EQ(posed.object, makeObjectId(1, 2));
  EXPECT_EQ(posed.material.stiffness, 700);
  EXPECT_EQ(posed.p_PO[0], 0.2);
  EXPECT_EQ(posed.tick, 3u);
}

}  // namespace
}  // namespace hapticd
