#include "rt/cycle/session_share.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

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
  session.lose(now, 50 * kMs);
  for (int i = 0; i < 25; ++i) last = tick().stored;
  session.revive();
  for (int i = 0; i < 60; ++i) {
    const auto s = tick();
    ASSERT_NEAR(1e-3 * s.carried.z(), s.stored - last, 1e-12) << "from half of it, " << i;
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

/** Four hands with forces of their own: each falls from its own, and comes back to it, once and again. */
TEST_F(ShareTest, EachDeviceFadesAndReturnsByItself) {
  for (std::uint32_t d = 0; d < kMaxDevices; ++d) {
    hd_client_force x{};
    x.device = d;
    x.lease_ns = 10'000 * kMs;
    store(Vec3(1.0 + d, 0, 0), x.force);
    store(Vec3(0, 0.1 + d, 0), x.torque);
    ASSERT_EQ(apply(CommandKind::kClientForce, x), ErrorCode::kOk);
  }
  const auto expectPart = [&](double part) {
    now += kMs;
    for (std::uint32_t d = 0; d < kMaxDevices; ++d) {
      tool.device = d;
      const auto s = session.evaluate(tool, now, scene);
      ASSERT_NEAR(s.client_force.x(), part * (1 + d), 1e-12) << d;
      ASSERT_NEAR(s.client_torque.y(), part * (0.1 + d), 1e-12) << d;
    }
  };
  for (int times = 0; times < 3; ++times) {
    expectPart(1);
    session.lose(now, 50 * kMs);
    for (int i = 1; i <= 25; ++i) expectPart(1 - i / 50.0);
    session.revive();
    for (int i = 0; i <= 50; ++i) expectPart(0.5 + i / 100.0);
  }
  expectPart(1);
}

TEST_F(ShareTest, OnlyWhatIsLostIsRevived) {
  ASSERT_EQ(force({2, 0, 0}), ErrorCode::kOk);
  (void)tick();
  session.lose(now, 50 * kMs);
  session.revive();
  for (int i = 0; i < 60; ++i) (void)tick();
  session.revive();
  ASSERT_EQ(force({4, 0, 0}), ErrorCode::kOk);
  EXPECT_EQ(tick().client_force, Vec3(4, 0, 0)) << "of one that is alive it comes at once";
  session.free();
  session.revive();
  EXPECT_EQ(session.life(), SessionShare::Life::kFree);
  EXPECT_EQ(session.last(0), Vec3(0, 0, 0)) << "nobody is shown what the former one felt";
}

TEST_F(ShareTest, ALossThatTakesNoTimeIsAtOnce) {
  for (const std::int64_t fade_ns : {std::int64_t{0}, -kMs}) {
    ASSERT_EQ(force({2, 0, 0}), ErrorCode::kOk);
    (void)tick();
    session.lose(now, fade_ns);
    EXPECT_EQ(session.fade(now), 0.0f);
    EXPECT_EQ(tick().client_force, Vec3(0, 0, 0));
    session.revive();
    EXPECT_EQ(tick().client_force, Vec3(2, 0, 0));
  }
}

TEST_F(ShareTest, ALeaseThatIsOverBeforeItBeginsIsNone) {
  now = 500 * kMs;
  ASSERT_EQ(force({1, 0, 0}, -1000), ErrorCode::kOk);
  for (int i = 1; i <= 50; ++i) ASSERT_NEAR(tick().client_force.x(), 1 - i / 50.0, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(tick().client_force, Vec3(0, 0, 0));
  ASSERT_EQ(force({3, 0, 0}), ErrorCode::kOk);
  EXPECT_EQ(tick().client_force, Vec3(3, 0, 0));
}

/** Two walls and two springs, which all change in the middle; `which` of them, by bits. */
SessionShare::Share sharesOf(SessionShare& session, unsigned which, int ticks, const hd_limits& limits, Scene& scene) {
  session.start(1);
  EXPECT_EQ(session.apply(makeCommand(CommandKind::kLimits, limits), 0, scene), ErrorCode::kOk);
  const ToolPoint tool{{-0.001, 0, -0.002}, {0.02, 0, -0.03}, 0};
  SessionShare::Share share;
  for (int i = 0; i < ticks; ++i) {
    for (std::uint32_t slot = 0; slot < 4; ++slot) {
      if ((which >> slot & 1u) == 0 || (i != 0 && i != 20)) continue;
      hd_local_model m =
          modelOf(slot < 2 ? HD_MODEL_PLANE : HD_MODEL_SPRING, (i == 0 ? 300 : 500) + 100 * slot, 1 + slot);
      m.slot = slot;
      m.normal[0] = slot % 2;
      m.normal[2] = 1 - slot % 2;
      EXPECT_EQ(session.apply(commandOf(m), i * kMs, scene), ErrorCode::kOk);
    }
    share = session.evaluate(tool, (i + 1) * kMs, scene);
  }
  return share;
}

TEST_F(ShareTest, ModelsAddUp) {
  constexpr hd_limits kNone{1e6, 1e6};
  bool all_told = false;
  for (int ticks = 1; ticks < 40; ++ticks) {
    SessionShare::Share sum;
    for (std::uint32_t slot = 0; slot < 4; ++slot) {
      const auto s = sharesOf(session, 1u << slot, ticks, kNone, scene);
      ASSERT_EQ(s.local_active, slot >= 2 ? s.local_model : Vec3(Vec3::Zero())) << "of springs all";
      ASSERT_GE(s.carried.sum(), 0) << "they only grow stiffer";
      sum.local_model += s.local_model;
      sum.local_active += s.local_active;
      sum.carried += s.carried;
      sum.stored += s.stored;
      sum.damping += s.damping;
    }
    const auto s = sharesOf(session, 15, ticks, kNone, scene);
    ASSERT_LT((s.local_model - sum.local_model).norm(), 1e-12) << ticks;
    ASSERT_LT((s.local_active - sum.local_active).norm(), 1e-12) << ticks;
    ASSERT_LT((s.carried - sum.carried).norm(), 1e-12) << ticks;
    ASSERT_NEAR(s.stored, sum.stored, 1e-12) << ticks;
    ASSERT_NEAR(s.damping, sum.damping, 1e-12) << ticks;
    all_told = all_told || (s.local_active.norm() > 0.1 && s.carried.norm() > 1e-3 && s.damping > 1);
  }
  EXPECT_TRUE(all_told);
}

/** What a limit leaves of a force it leaves of all that belongs to it; of a spring's energy f (2 - f). */
TEST_F(ShareTest, ALimitBindsAllThatBelongsToTheForce) {
  for (int ticks = 1; ticks < 40; ++ticks) {
    const auto all = sharesOf(session, 15, ticks, {1e6, 1e6}, scene);
    const double f = 0.3, most = f * all.local_model.norm();
    const auto s = sharesOf(session, 15, ticks, {most, 0}, scene);
    ASSERT_LT((s.local_model - f * all.local_model).norm(), 1e-12) << ticks;
    ASSERT_LT((s.local_active - f * all.local_active).norm(), 1e-12) << ticks;
    ASSERT_LT((s.carried - f * all.carried).norm(), 1e-12) << ticks;
    ASSERT_NEAR(s.stored, f * (2 - f) * all.stored, 1e-12) << ticks;
    ASSERT_NEAR(s.damping, f * all.damping, 1e-12) << ticks;
  }
}

TEST_F(ShareTest, ALimitOfNothingLeavesNothing) {
  ASSERT_EQ(force({3, 0, 0}), ErrorCode::kOk);
  ASSERT_EQ(limits(0, 0), ErrorCode::kOk);
  const auto s = tick();
  EXPECT_EQ(total(s), Vec3(0, 0, 0));
  EXPECT_EQ(s.client_torque, Vec3(0, 0, 0));
}

/** The first takes what it is told to damp by, the next what is left. */
TEST_F(ShareTest, ModelsDampTogetherByWhatTheyMay) {
  tool.v = {0, 0, -0.05};
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    hd_local_model m = modelOf(HD_MODEL_PLANE, 500, 3);
    m.slot = slot;
    ASSERT_EQ(model(m), ErrorCode::kOk);
  }
  for (const double most : {0.0, 2.0, 4.0, 8.0, 20.0}) {
    tool.most_damping = most;
    for (int i = 0; i < 20; ++i) (void)tick();
    const auto s = tick();
    EXPECT_NEAR(s.damping, std::min(most, 9.0), 1e-12) << most;
    EXPECT_NEAR(s.local_model.z(), 3 * 500 * 0.002 + 0.05 * std::min(most, 9.0), 1e-12) << most;
  }
}

TEST_F(ShareTest, ForcesTooLargeForTheirSizeCountAsNothing) {
  for (const bool torque : {false, true}) {
    hd_client_force x{};
    x.lease_ns = 1000 * kMs;
    store(Vec3(1, 1, 1), x.force);
    store(Vec3(1, 1, 1), x.torque);
    store(Vec3(1e308, 1e308, 1e308), torque ? x.torque : x.force);
    ASSERT_EQ(apply(CommandKind::kClientForce, x), ErrorCode::kOk);
    const auto s = tick();
    EXPECT_EQ(total(s), Vec3(0, 0, 0));
    EXPECT_EQ(s.client_torque, Vec3(0, 0, 0));
  }
}

/** For the rest of their lease, and as what was said by others than the client's ring. */
TEST_F(ShareTest, WhatIsRestatedLastsNoLonger) {
  now = 100 * kMs;
  ASSERT_EQ(force({3, 0, 0}, 1000), ErrorCode::kOk);
  ASSERT_EQ(model(modelOf(HD_MODEL_PLANE, 2000)), ErrorCode::kOk);
  hd_local_model other = modelOf(HD_MODEL_SPRING);
  other.slot = HD_MODEL_SLOTS - 1;
  ASSERT_EQ(model(other), ErrorCode::kOk);
  session.noteApplied(5, 6);
  now = 400 * kMs;
  std::vector<Command> said;
  session.restate(now, said);
  ASSERT_EQ(said.size(), 4u);
  EXPECT_EQ(said[0].seq, 5u);
  EXPECT_EQ(said[0].channel, 0u);
  EXPECT_EQ(said[1].channel, 1u);
  EXPECT_EQ(said[1].as<hd_local_model>().lease_ns, 700 * kMs);
  EXPECT_EQ(said[2].as<hd_local_model>().slot, other.slot);
  EXPECT_EQ(said[3].channel, 1u);
  EXPECT_EQ(said[3].as<hd_client_force>().lease_ns, 700 * kMs);
  now = 1100 * kMs;
  said.clear();
  session.restate(now, said);
  EXPECT_EQ(said.size(), 1u) << "the limits alone";
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
  hd_force_field field{};
  field.radius = 0.1;
  field.lease_ns = 1000 * kMs;
  field.f0[0] = 1;
  field.slot = HD_MODEL_SLOTS;
  EXPECT_EQ(apply(CommandKind::kForceField, field), ErrorCode::kInvalidArgument);
  field.slot = HD_MODEL_SLOTS - 1;
  EXPECT_EQ(apply(CommandKind::kForceField, field), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) (void)tick();
  EXPECT_NEAR(tick().local_model.x(), 1, 1e-12);
  tool.device = kMaxDevices;
  EXPECT_EQ(total(tick()), Vec3(0, 0, 0));
}

}  // namespace
}  // namespace hapticd
