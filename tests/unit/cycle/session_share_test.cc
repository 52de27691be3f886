#include "rt/cycle/session_share.h"

#include <gtest/gtest.h>

#include "tests/unit/render/model_rig.h"

namespace hapticd {
namespace {

class ShareTest : public ::testing::Test {
 protected:
  MeshTable meshes;
  Scene scene{meshes};
  SessionShare session;
  ToolPoint tool{{0, 0, -0.002}, Vec3::Zero(), 0};
  std::int64_t now = 0;

  void SetUp() override { session.start(7); }
  SessionShare::Share tick() {
    now += kMs;
    return session.evaluate(tool, now, scene);
  }
  static Vec3 total(const SessionShare::Share& s) { return s.local_model + s.client_force; }
  ErrorCode force(const Vec3& f, std::int64_t lease_ms = 1000) {
    hd_client_force x{};
    x.lease_ns = lease_ms * kMs;
    store(f, x.force);
    store(Vec3(0.1 * f), x.torque);
    return apply(CommandKind::kClientForce, x);
  }
  ErrorCode limits(double f, double t) { return apply(CommandKind::kLimits, hd_limits{f, t}); }
  ErrorCode model(const hd_local_model& m) { return session.apply(commandOf(m), now, scene); }
  ErrorCode clear(std::uint32_t slot) { return apply(CommandKind::kClearModel, hd_clear_model{slot, 0, 0}); }
  template <class T>
  ErrorCode apply(CommandKind kind, const T& payload) {
    return session.apply(makeCommand(kind, payload), now, scene);
  }
};

TEST_F(ShareTest, ClientForceHoldsThenFades) {
  ASSERT_EQ(force({1, 2, 0}, 100), ErrorCode::kOk);
  for (int i = 1; i <= 100; ++i) ASSERT_EQ(tick().client_force, Vec3(1, 2, 0));
  for (int i = 1; i <= 50; ++i) {
    const auto s = tick();
    ASSERT_NEAR(s.client_force.x(), 1 - i / 50.0, 1e-12);
    ASSERT_NEAR(s.client_torque.y(), 0.2 * (1 - i / 50.0), 1e-12);
  }
  EXPECT_EQ(tick().client_force, Vec3(0, 0, 0));
}

TEST_F(ShareTest, ClientsOwnLimitBindsItsWholeShare) {
  ASSERT_EQ(force({3, 0, 0}), ErrorCode::kOk);
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 2000)), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  EXPECT_NEAR(total(tick()).norm(), 5, 1e-12);
  ASSERT_EQ(limits(2.5, 0.15), ErrorCode::kOk);
  const auto s = tick();
  EXPECT_LT((total(s) - Vec3(1.5, 0, 2)).norm(), 1e-12);
  EXPECT_LT((s.client_force - Vec3(1.5, 0, 0)).norm(), 1e-12) << "each source shrinks alike";
  EXPECT_NEAR(s.client_torque.norm(), 0.15, 1e-12);
  EXPECT_LT((session.last(0) - total(s)).norm(), 1e-15);
  EXPECT_EQ(limits(-1, 1), ErrorCode::kInvalidArgument);
  EXPECT_EQ(limits(std::nan(""), 1), ErrorCode::kInvalidArgument);
}

TEST_F(ShareTest, ALimitedSpringStoresWhatItGivesBack) {
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 2000)), ErrorCode::kOk);
  ASSERT_EQ(limits(2.5, 0.15), ErrorCode::kOk);
  tool.p.z() = 0.0001;
  for (int i = 0; i < 20; ++i) (void)tick();
  double work = 0, last = 0;
  for (int i = 1; i <= 200; ++i) {  // To 20 mm, of which the first 1.25 mm are within the limit.
    tool.p.z() = -1e-4 * i;
    const auto s = tick();
    work += 0.5e-4 * (s.local_model.z() + last);
    last = s.local_model.z();
    ASSERT_NEAR(s.stored, work, 1e-5) << i;  // The step in which the limit begins lies half in it.
  }
  EXPECT_NEAR(last, 2.5, 1e-12);
}

TEST_F(ShareTest, LostShareFallsMonotonicallyWhateverTheHandDoes) {
  ASSERT_EQ(force({1, 0, 0}, 10'000), ErrorCode::kOk);
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 500)), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  double last = total(tick()).norm();
  double last_torque = 0.1;
  ASSERT_NEAR(last, std::sqrt(2.0), 1e-12);
  session.lose(now, 50 * kMs);
  for (int i = 1; i <= 60; ++i) {
    tool.p.z() = i % 7 == 0 ? 0.01 : -0.002 - 0.001 * i;  // Presses ever deeper, with moments of air.
    if (i == 20) {
      ASSERT_EQ(force({9, 9, 9}), ErrorCode::kOk);  // A late command.
    }
    const auto s = tick();
    const double present = total(s).norm();
    ASSERT_LE(present, last + 1e-12) << i;
    ASSERT_LE(present, std::sqrt(2.0) * std::max(0.0, 1 - i / 50.0) + 1e-12);
    ASSERT_LE(s.client_torque.norm(), last_torque + 1e-12);
    last = present;
    last_torque = s.client_torque.norm();
    if (i >= 50) {
      ASSERT_EQ(present, 0);
      ASSERT_EQ(last_torque, 0);
    }
  }
  EXPECT_EQ(session.fade(now), 0.0f);
}

TEST_F(ShareTest, LostShareFallsSteadilyIfNothingElseChanges) {
  ASSERT_EQ(force({2, 0, 0}, 10'000), ErrorCode::kOk);
  for (int i = 0; i < 5; ++i) (void)tick();
  session.lose(now, 50 * kMs);
  for (int i = 1; i <= 60; ++i) {
    const auto s = tick();
    ASSERT_NEAR(s.client_force.x(), 2 * std::max(0.0, 1 - i / 50.0), 1e-12) << i;
    ASSERT_NEAR(s.client_torque.x(), 0.2 * std::max(0.0, 1 - i / 50.0), 1e-12) << i;
  }
}

TEST_F(ShareTest, RevivedShareComesBackWithoutAJump) {
  ASSERT_EQ(force({2, 0, 0}, 10'000), ErrorCode::kOk);
  for (int i = 0; i < 5; ++i) (void)tick();
  session.lose(now, 50 * kMs);
  double last = 0;
  for (int i = 0; i < 25; ++i) last = total(tick()).norm();
  ASSERT_NEAR(last, 1, 1e-12);
  session.revive();
  EXPECT_EQ(session.life(), SessionShare::Life::kAlive);
  for (int i = 0; i <= 50; ++i) {
    const double present = total(tick()).norm();
    ASSERT_NEAR(present, 1 + i / 50.0, 1e-12);
  }
  EXPECT_NEAR(total(tick()).norm(), 2, 1e-12);
  EXPECT_EQ(session.fade(now), 1.0f);
}

TEST_F(ShareTest, WhatAReturnAddsToTheSpringsIsCharged) {
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 500)), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  session.lose(now, 50 * kMs);
  for (int i = 0; i < 60; ++i) (void)tick();
  tool.p.z() = -0.01;  // It has fallen in meanwhile.
  ASSERT_EQ(tick().stored, 0);
  session.revive();
  double last = 0;
  for (int i = 0; i < 60; ++i) {
    const auto s = tick();
    ASSERT_NEAR(1e-3 * s.carried.z(), s.stored - last, 1e-12) << i;
    last = s.stored;
  }
  EXPECT_NEAR(last, 0.5 * 500 * 0.01 * 0.01, 1e-12);
}

TEST_F(ShareTest, FreedSlotForgetsEverything) {
  ASSERT_EQ(force({2, 0, 0}), ErrorCode::kOk);
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE)), ErrorCode::kOk);
  ASSERT_EQ(limits(1, 1), ErrorCode::kOk);
  (void)tick();
  session.free();
  EXPECT_EQ(total(tick()), Vec3(0, 0, 0));
  EXPECT_EQ(force({2, 0, 0}), ErrorCode::kNotFound);
  session.start(8);
  EXPECT_EQ(total(tick()), Vec3(0, 0, 0));
  ASSERT_EQ(force({2, 0, 0}), ErrorCode::kOk);
  EXPECT_EQ(tick().client_force, Vec3(2, 0, 0)) << "the former client's limit is gone";
}

TEST_F(ShareTest, HugeValuesOfOneClientCountAsNothing) {
  hd_local_model m = modelOf(HD_MODEL_SPRING, 1e308);
  m.origin[0] = 1e308;
  ASSERT_EQ(model(m), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) {
    const auto s = tick();
    ASSERT_EQ(total(s), Vec3(0, 0, 0));
    ASSERT_TRUE(isFinite(s.carried) && std::isfinite(s.stored));
  }
}

TEST_F(ShareTest, AClearedModelIsGone) {
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 500)), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  ASSERT_NEAR(tick().local_model.z(), 1, 1e-12);
  ASSERT_EQ(clear(0), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  EXPECT_EQ(tick().local_model, Vec3(0, 0, 0));
}

/** What the limit binds is the force that the client brings about, and not the sum of what makes it. */
TEST_F(ShareTest, PartsThatCancelAreNotBound) {
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 2000)), ErrorCode::kOk);
  ASSERT_EQ(force({0, 0, -3}), ErrorCode::kOk);
  ASSERT_EQ(limits(1, 1), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  EXPECT_NEAR(tick().local_model.z(), 4, 1e-12);
  EXPECT_NEAR(tick().client_force.z(), -3, 1e-12);
}

TEST_F(ShareTest, TheFadeTellsHowMuchIsLeft) {
  EXPECT_EQ(session.fade(now), 1.0f);
  ASSERT_EQ(force({2, 0, 0}), ErrorCode::kOk);
  (void)tick();
  session.lose(now, 50 * kMs);
  for (int i = 0; i < 25; ++i) (void)tick();
  EXPECT_EQ(session.fade(now), 0.5f);
  session.lose(now, 50 * kMs);
  EXPECT_EQ(session.fade(now), 0.5f) << "lost again it falls no later";
  for (int i = 0; i < 30; ++i) (void)tick();
  EXPECT_EQ(session.fade(now), 0.0f);
  session.revive();
  EXPECT_EQ(session.fade(now), 0.0f);
  for (int i = 0; i < 26; ++i) (void)tick();
  EXPECT_EQ(session.fade(now), 0.5f);
  session.lose(now, 50 * kMs);
  EXPECT_EQ(session.fade(now), 1.0f);
  session.revive();
  session.free();
  EXPECT_EQ(session.fade(now), 0.0f);
  session.start(9);
  EXPECT_EQ(session.fade(now), 1.0f);
}

TEST_F(ShareTest, ASlotKnowsWhoseItIs) {
  EXPECT_EQ(session.id(), 7u);
  session.noteApplied(5, 6);
  session.free();
  EXPECT_EQ(session.id(), 0u);
  session.start(8);
  EXPECT_EQ(session.id(), 8u);
  EXPECT_EQ(session.appliedSeq(), 0u);
  EXPECT_EQ(session.appliedTick(), 0u);
}

TEST_F(ShareTest, WhatIsRestatedGivesTheSameForce) {
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 2000)), ErrorCode::kOk);
  ASSERT_EQ(force({3, 0, 0}), ErrorCode::kOk);
  ASSERT_EQ(limits(2.5, 0.15), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  std::vector<Command> said;
  session.restate(now, said);
  ASSERT_EQ(said.size(), 3u) << "limits, one model, one force, and nothing of what is not set";
  const Vec3 before = total(tick());
  session.start(7);
  for (const Command& command : said) ASSERT_EQ(session.apply(command, now, scene), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  EXPECT_LT((total(tick()) - before).norm(), 1e-12);
}

TEST_F(ShareTest, WhatFadesOutIsNotRestated) {
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 2000)), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  ASSERT_EQ(clear(modelOf(HD_MODEL_PLANE).slot), ErrorCode::kOk);
  for (int i = 0; i < 2; ++i) {  // Also before its first tick.
    std::vector<Command> said;
    session.restate(now, said);
    EXPECT_EQ(said.size(), 1u) << "the limits alone";
    (void)tick();
  }
}

TEST_F(ShareTest, RefusesSlotsDevicesAndKinds) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.slot = HD_MODEL_SLOTS;
  EXPECT_EQ(model(m), ErrorCode::kInvalidArgument);
  EXPECT_EQ(clear(HD_MODEL_SLOTS), ErrorCode::kInvalidArgument);
  hd_client_force force{};
  force.device = kMaxDevices;
  EXPECT_EQ(apply(CommandKind::kClientForce, force), ErrorCode::kInvalidArgument);
  for (const bool torque : {false, true}) {
    force = {};
    (torque ? force.torque : force.force)[1] = std::nan("");
    EXPECT_EQ(apply(CommandKind::kClientForce, force), ErrorCode::kInvalidArgument);
  }
  EXPECT_EQ(apply(CommandKind::kArm, DeviceRef{0}), ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace hapticd
