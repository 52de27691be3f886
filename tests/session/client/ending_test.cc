// Sessions that end at odd moments: before they are live, twice, while ingest hangs, or that never come to be.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

class SessionEnding : public testing::Test {
 protected:
  Result<Session*> open(std::uint64_t by) {
    return bench.core.openSession("", by, "guest", HD_SHM_MAJOR, HD_SHM_MINOR);
  }
  SessionShare::Life life(std::uint32_t slot) {
    auto out = SessionShare::Life::kFree;
    const auto look = [&](Servo& servo) { out = servo.cycle().session(slot).life(); };
    EXPECT_TRUE(bench.device().link->group().betweenCycles(look).ok());
    return out;
  }
  Bench bench;
  std::uint64_t guest = *bench.core.connect(200, 1001, false);
};

TEST_F(SessionEnding, BeforeItIsLiveTheServoLetsItGoToo) {
  auto session = open(guest);
  ASSERT_TRUE(session.ok());
  const std::uint32_t slot = (*session)->slot;
  ASSERT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
  bench.core.poll();
  bench.device().link->group().servo().runOnce();
  ASSERT_NE(life(slot), SessionShare::Life::kFree);
  ASSERT_EQ((*session)->state, Session::State::kAdding);
  bench.core.disconnect(guest);
  for (int i = 0; i < 10 && !bench.core.sessions().empty(); ++i) bench.step();
  EXPECT_TRUE(bench.core.sessions().empty());
  EXPECT_EQ(life(slot), SessionShare::Life::kFree) << "else it would write into memory that is unmapped";
  bench.step(5);
}

TEST_F(SessionEnding, ASecondTimeAndOfNobodyIsNothing) {
  auto session = open(guest);
  ASSERT_TRUE(session.ok());
  const ClientSide side(**session);
  ASSERT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
  side.producer->heartbeat(bench.clock.now());
  bench.step(4);
  bench.core.sessions().end((*session)->id, "for the test");
  bench.core.sessions().end((*session)->id, "again");
  bench.core.sessions().end(4711, "there is none");
  bench.core.disconnect(guest);
  EXPECT_EQ((*session)->state, Session::State::kEnding) << "it still fades";
  EXPECT_EQ((*session)->why, "for the test");
  bench.step(150);
  EXPECT_TRUE(bench.core.sessions().empty());
  bench.core.sessions().report(*bench.device().link, {});  // Of a slot that nobody has any more.
}

/** A device is not closed under a session that is there or fades: it counts them. */
TEST_F(SessionEnding, ItsDeviceCountsItUntilItHasFaded) {
  const std::uint32_t& count = bench.device().sessions;
  ASSERT_EQ(count, 0u);
  auto fading = open(guest);
  auto offered = open(guest);
  ASSERT_TRUE(fading.ok() && offered.ok());
  EXPECT_EQ(count, 2u);
  const ClientSide side(**fading);
  ASSERT_TRUE(bench.core.sessions().mapped((*fading)->id).ok());
  bench.step(4);
  for (const std::uint64_t id : {(*fading)->id, (*offered)->id}) bench.core.sessions().end(id, "for the test");
  bench.step(3);
  EXPECT_EQ(count, 1u) << "of the other the servo never heard";
  EXPECT_EQ(bench.core.devices().close(bench.device()).error().code, ErrorCode::kDeviceBusy);
  bench.step(150);
  EXPECT_EQ(count, 0u);
  bench.core.disconnect(guest);
  EXPECT_EQ(count, 0u) << "once each";
}

/** A thread that hangs keeps no force in a hand. */
TEST_F(SessionEnding, ItsForceFadesThoughIngestDoesNotLetGo) {
  Session* holder = bench.live();
  ASSERT_TRUE(bench.arm(holder->id).ok());
  auto session = open(guest);
  ASSERT_TRUE(session.ok());
  const ClientSide side(**session);
  ASSERT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
  side.producer->heartbeat(bench.clock.now());
  bench.step(40);
  ASSERT_EQ(side.push(Vec3(1, 0, 0)), ErrorCode::kOk);
  bench.step(60);
  ASSERT_NEAR(bench.sample().force[0], 1.0, 1e-3);
  bench.core.disconnect(guest);
  for (int i = 0; i < 60; ++i) {
    bench.device().link->group().servo().runOnce();
    bench.core.poll();
  }
  EXPECT_EQ(bench.sample().force[0], 0.0);
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(bench.core.sessions().all().size(), 2u) << "but its memory stays while ingest may look at it";
}

TEST_F(SessionEnding, WhatItStillSendsIsRefusedByThatName) {
  const Session* const session = bench.live();
  ASSERT_NE(session, nullptr);
  testing::internal::CaptureStderr();
  bench.core.sessions().end(session->id, "the test wants it");
  ASSERT_EQ(bench.client->push(Vec3(1, 0, 0)), ErrorCode::kOk);
  bench.step(5);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("the session that gave it has ended"), std::string::npos) << said;
}

TEST_F(SessionEnding, MappedASecondTimeItStaysLive) {
  Session* session = bench.live();
  EXPECT_TRUE(bench.core.sessions().mapped(session->id).ok());
  EXPECT_EQ(session->state, Session::State::kLive);
}

/** A client has the file, and so may seal it before its time. */
TEST_F(SessionEnding, WhoseMemoryCannotBeSealedIsRefused) {
  auto session = open(guest);
  ASSERT_TRUE(session.ok());
  const std::uint64_t id = (*session)->id;
  ASSERT_EQ(fcntl((*session)->regions.fileB().fd(), F_ADD_SEALS, F_SEAL_SEAL), 0);
  EXPECT_FALSE(bench.core.sessions().mapped(id).ok());
  EXPECT_EQ(bench.core.sessions().find(id), nullptr);
  bench.step();
  EXPECT_TRUE(bench.core.sessions().empty());
}

TEST_F(SessionEnding, WithoutDescriptorsThereIsNone) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  int refused = 0;
  for (rlim_t most = 0; most < before.rlim_cur; ++most) {
    const rlimit few{most, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
    const bool opened = open(guest).ok();
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
    if (opened) break;
    ++refused;
  }
  EXPECT_GE(refused, 5) << "three that any program has, and two of its own";
  EXPECT_EQ(bench.core.sessions().all().size(), 1u);
}

}  // namespace
}  // namespace hapticd::test
