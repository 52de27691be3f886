// A client whose heartbeat comes back just when it is taken for gone still fades, and nothing cuts its force off.

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

/** A holder's armed device, and a guest that pushes it with 1 N. */
class Revived : public testing::Test {
 protected:
  Revived() {
    const Session* holder = bench.live();
    EXPECT_TRUE(bench.arm(holder->id).ok());
    guest = *bench.core.connect(200, 1001, false);
    auto session = bench.core.openSession("", guest, "guest", HD_SHM_MAJOR, HD_SHM_MINOR);
    EXPECT_TRUE(session.ok());
    client = std::make_unique<ClientSide>(**session);
    EXPECT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
    step(40);
    EXPECT_EQ(client->push(Vec3(1, 0, 0)), ErrorCode::kOk);
    step(60);
    EXPECT_NEAR(force(), 1, 1e-3);
  }
  /** The guest lives. */
  void step(int periods) {
    for (int i = 0; i < periods; ++i) {
      client->producer->heartbeat(bench.clock.now());
      bench.step();
    }
  }
  double force() { return bench.sample().force[0]; }
  void expectFade() {
    double last = force();
    for (int i = 0; i < 300; ++i) {
      bench.step();
      ASSERT_GT(force(), last - 0.03) << "period " << i << ": it fades over 50, it is not cut off";
      last = std::max(force(), 0.0);
    }
    EXPECT_EQ(last, 0);
  }
  Bench bench;
  std::uint64_t guest = 0;
  std::unique_ptr<ClientSide> client;
};

TEST_F(Revived, BetweenItsEndAndIngestsLettingGoItFadesAllTheSame) {
  bench.step(300);
  ASSERT_EQ(force(), 0) << "its heartbeat was late";
  DeviceGroup& group = bench.device().link->group();
  client->producer->heartbeat(bench.clock.now());
  bench.core.disconnect(guest);  // The loss overtakes ingest's word that it lives ...
  for (int i = 0; i < 45; ++i) {
    group.ingest().step(bench.clock.now(), 0);
    group.servo().runOnce();
  }
  ASSERT_GT(force(), 0.5) << "... which therefore holds";
  for (int i = 0; i < 1000; ++i) bench.device().applyRadius();  // The next loss has to wait its turn.
  expectFade();
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(bench.core.sessions().all().size(), 1u);
}

TEST_F(Revived, WhileTheServoTakesNothingItFadesAllTheSame) {
  bench.step(300);
  ASSERT_EQ(force(), 0) << "its heartbeat was late";
  DeviceGroup& group = bench.device().link->group();
  client->producer->heartbeat(bench.clock.now());
  bench.core.disconnect(guest);
  for (int i = 0; i < 10; ++i) {  // Ingest says that it lives and lets go of it, all between two of the servo's cycles.
    group.ingest().step(bench.clock.now(), 0);
    bench.core.poll();
  }
  expectFade();
  EXPECT_EQ(bench.core.sessions().all().size(), 1u);
}

TEST_F(Revived, WhatItPushesAsItComesBackIsTaken) {
  bench.step(300);
  ASSERT_EQ(force(), 0) << "its heartbeat was late";
  EXPECT_EQ(client->push(Vec3(0.5, 0, 0)), ErrorCode::kOk);
  step(300);
  EXPECT_NEAR(force(), 0.5, 1e-3);
}

}  // namespace
}  // namespace hapticd::test
