// Where two servos have one object that moves by itself, stops flying, or is in a hand.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

class SamePlace : public testing::Test {
 protected:
  std::uint32_t make(const char* name) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
    spec.material = kDefaultMaterial;
    return bench.core.scene().create(spec, bench.core.client(bench.administration)).value();
  }
  const SceneObject& at(std::size_t group, std::uint32_t id) {
    return *bench.core.devices().links()[group]->group().servo().cycle().scene().find(id);
  }
  /** One of them runs more ticks than the other before control looks. */
  void step(int ticks, std::size_t group) {
    for (int i = 0; i < ticks; ++i) bench.core.devices().links()[group]->group().step();
  }
  double apart(std::uint32_t id) { return (at(0, id).X_PO.p - at(1, id).X_PO.p).norm(); }

  static constexpr double kV = 0.5, kTick = kV * 1e-3;  ///< [m/s, m]
  Bench bench;
};

TEST_F(SamePlace, WhatAClientGivesAVelocityGoesOnAlike) {
  ASSERT_NE(bench.live(), nullptr);
  const std::uint32_t id = make("parcel");
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  bench.step(40);
  const auto push = [&](double x) {
    const hd_object_pose pose = poseMessage(id, {{x, 0, 0}, Quat::Identity()}, {{kV, 0, 0}, Vec3::Zero()});
    std::uint64_t seq = 0;
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
              ErrorCode::kOk);
    step(5, 0);
    bench.core.poll();
  };
  push(0);
  push(0.05);  // The other has not taken the first order, and waits for this one.
  step(20, 0);
  bench.step(60);
  EXPECT_GT(at(1, id).X_PO.p.x(), 0.05 + 80 * kTick);
  EXPECT_LE(apart(id), 1.01 * kTick);
}

TEST_F(SamePlace, AServoThatComesLateHasItWhereItIs) {
  const std::uint32_t id = make("parcel");
  ASSERT_TRUE(bench.core.scene().setVelocity("parcel", {{kV, 0, 0}, Vec3::Zero()}).ok());
  bench.step(40);
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  step(30, 0);  // The second takes its orders later.
  bench.step(60);
  EXPECT_LE(apart(id), 1.01 * kTick);
}

// It had been given its velocity before, and went back by all that it had moved since when control was asked for it.
TEST_F(SamePlace, WhatTheOnlyServoHasMovedIsNotPutBack) {
  bench.core.disconnect(bench.connection);
  bench.step(100);
  ASSERT_TRUE(bench.core.closeDevice("test://first", bench.administration).ok());
  const std::uint32_t id = make("parcel");
  ASSERT_TRUE(bench.core.scene().setVelocity("parcel", {{kV, 0, 0}, Vec3::Zero()}).ok());
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  bench.step(100);
  const double before = at(0, id).X_PO.p.x();
  ASSERT_GT(before, 90 * kTick);
  EXPECT_TRUE(bench.core.scene().find("parcel").ok());
  bench.step(2);
  EXPECT_GT(at(0, id).X_PO.p.x(), before);
}

// Recordings, one after the other, each left it farther behind.
TEST_F(SamePlace, WhatGoesOnWhileAServoStandsIsNotLeftBehind) {
  const std::uint32_t id = make("parcel");
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  bench.step(40);
  ASSERT_TRUE(bench.core.scene().setVelocity("parcel", {{kV, 0, 0}, Vec3::Zero()}).ok());
  bench.step(40);
  const double before = at(0, id).X_PO.p.x();
  auto& servo = bench.core.devices().links().front()->group().servo();
  constexpr int kPassed = 7;
  bench.clock.advance(kPassed * 1'000'000);
  servo.skipPassed();
  step(1, 0);
  EXPECT_NEAR(at(0, id).X_PO.p.x() - before, (kPassed + 1) * kTick, 1e-9);
  EXPECT_EQ(servo.counters.missed.load(), 0u);
}

TEST_F(SamePlace, WhatIsNoBodyAnyMoreStandsAlike) {
  const std::uint32_t id = make("ball");
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  ASSERT_TRUE(bench.core.scene().setGravity({0, 0, -9.81}).ok());
  bench.step(40);
  for (const int ahead : {0, 1, 3, 10}) {
    for (const bool plane : {false, true}) {
      SCOPED_TRACE(testing::Message() << ahead << " ticks ahead, " << (plane ? "a plane" : "without mass"));
      ASSERT_TRUE(bench.core.scene().setShape("ball", {ShapeKind::kSphere, {0.01, 0, 0}, 0}).ok());
      ASSERT_TRUE(bench.core.scene().setPose("ball", {{0, 0, 1}, Quat::Identity()}).ok());
      ASSERT_TRUE(bench.core.scene().setBody("ball", {.mass = 0.1}).ok());
      bench.step(100);
      ASSERT_LT(at(1, id).V_PO.v.z(), -0.3) << "it falls";
      step(ahead, 0);
      bench.core.poll();
      step(1, 0);
      if (plane) {
        ASSERT_TRUE(bench.core.scene().setShape("ball", {ShapeKind::kPlane, {}, 0}).ok());
      } else {
        ASSERT_TRUE(bench.core.scene().setBody("ball", {}).ok());
      }
      bench.step(60);
      for (const std::size_t group : {0, 1}) EXPECT_TRUE(at(group, id).V_PO.v.isZero(0)) << group;
      EXPECT_LE(apart(id), 1e-12);
      EXPECT_EQ(bench.core.scene().find("ball")->spec.X_PO.p, at(0, id).X_PO.p);
      EXPECT_TRUE(bench.core.scene().find("ball")->V_PO.v.isZero(0));
    }
  }
}

TEST_F(SamePlace, WhatIsInAHandIsThereForEverybody) {
  ASSERT_NE(bench.live(), nullptr);
  const std::uint32_t id = make("tool");
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  bench.step(40);
  const Client& by = bench.core.client(bench.administration);
  ASSERT_TRUE(bench.core.attachTool(bench.device(1), {.object = "tool"}, by).ok());
  bench.step(40);
  const auto push = [&](double x) {
    const hd_object_pose pose = poseMessage(id, {{x, 0, 0}, Quat::Identity()});
    std::uint64_t seq = 0;
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
              ErrorCode::kOk);
  };
  hd_object_flags flags{id, ~0u, 0u, 0};  // Nor may a client say that it is not.
  flags.value = HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE;
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_FLAGS, std::as_bytes(std::span(&flags, 1)), 0, seq),
            ErrorCode::kOk);
  bench.step(5);
  for (int i = 0; i < 20; ++i) {
    push(0.2);
    bench.step(1);
    for (const std::size_t group : {0, 1}) EXPECT_LT(at(group, id).X_PO.p.norm(), 0.01) << group;
  }
  ASSERT_TRUE(bench.core.detachTool(bench.device(1), by).ok());
  bench.step(40);
  push(0.2);
  bench.step(40);
  for (const std::size_t group : {0, 1}) EXPECT_EQ(at(group, id).X_PO.p.x(), 0.2) << group;

  ASSERT_TRUE(bench.core.attachTool(bench.device(1), {.object = "tool"}, by).ok());
  bench.step(40);
  ASSERT_TRUE(bench.core.closeDevice("test://second", bench.administration).ok());
  bench.step(5);
  push(0.1);
  bench.step(20);
  EXPECT_EQ(at(0, id).X_PO.p.x(), 0.1) << "its hand is gone";
}

}  // namespace
}  // namespace hapticd::test
