// A session goes from servo to ingest and back only when each has really taken, or let go of, the memory.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

class Handover : public testing::Test {
 protected:
  Handover() {
    auto session = bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
    EXPECT_TRUE(session.ok());
    session_ = *session;
    client_ = std::make_unique<ClientSide>(*session_);
  }
  void map() { ASSERT_TRUE(bench.core.sessions().mapped(session_->id).ok()); }
  DeviceGroup& group() { return bench.device().link->group(); }
  void stepServo(int periods) {
    for (int i = 0; i < periods; ++i) group().servo().runOnce(), bench.core.poll();
  }
  void stepIngest(int periods) {
    for (int i = 0; i < periods; ++i) group().ingest().step(bench.clock.now(), 0), bench.core.poll();
  }
  /** Orders that come to nothing, until no more fits. */
  void fillIngest() {
    IngestOrder nobodys;
    nobodys.slot = kMaxSessions;
    while (group().ingest().orders.push(nobodys)) {
    }
  }
  Bench bench;
  Session* session_ = nullptr;
  std::unique_ptr<ClientSide> client_;
};

TEST_F(Handover, IngestGetsItWhenTheServoHasIt) {
  map();
  stepIngest(5);
  EXPECT_EQ(session_->state, Session::State::kAdding);
  stepServo(2);
  EXPECT_EQ(session_->state, Session::State::kLive);
}

TEST_F(Handover, WaitsForAnIngestThatTakesNoOrder) {
  fillIngest();
  map();
  stepServo(5);
  ASSERT_EQ(bench.core.sessions().all().size(), 1u);
  EXPECT_EQ(session_->state, Session::State::kAdding);
  bench.step();
  EXPECT_EQ(session_->state, Session::State::kLive);
  bench.step();
  client_->producer->heartbeat(bench.clock.now());
  fillIngest();
  bench.core.sessions().end(session_->id, "test");
  stepServo(200);
  ASSERT_EQ(bench.core.sessions().all().size(), 1u) << "it may still read the memory";
  EXPECT_EQ(session_->state, Session::State::kEnding);
  bench.step(100);
  EXPECT_TRUE(bench.core.sessions().empty());
}

TEST_F(Handover, ItsMemoryStaysUntilIngestHasLetGo) {
  map();
  bench.step(4);
  bench.core.sessions().end(session_->id, "test");
  stepServo(200);
  ASSERT_EQ(bench.core.sessions().all().size(), 1u);
  EXPECT_EQ(session_->state, Session::State::kEnding);
  stepIngest(3);
  stepServo(100);
  EXPECT_TRUE(bench.core.sessions().empty());
}

TEST_F(Handover, ItsMemoryStaysUntilTheServoHasLetGo) {
  map();
  bench.step(4);
  bench.core.sessions().end(session_->id, "test");
  for (int i = 0; i < 200 && session_->state != Session::State::kFreeing; ++i) bench.step();
  ASSERT_EQ(session_->state, Session::State::kFreeing);
  stepIngest(5);
  ASSERT_EQ(bench.core.sessions().all().size(), 1u);
  stepServo(2);
  EXPECT_TRUE(bench.core.sessions().empty());
}

}  // namespace
}  // namespace hapticd::test
