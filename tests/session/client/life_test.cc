// A session from the offer to the last unmapping, stepped by hand.
#include <fcntl.h>

#include <optional>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(SessionLife, OfferMapLiveAndReadableState) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  EXPECT_EQ(bench.client->a()->header.daemon_epoch, 42u);
  EXPECT_EQ(bench.client->a()->header.session_id, session->id);
  hd_sample sample{};
  bench.step(5);
  ASSERT_TRUE(StateReader(bench.client->a()).latest(0, sample));
  EXPECT_GT(sample.tick, 0u);
  EXPECT_EQ(sample.flags & HD_SAMPLE_ARMED, 0u);
}

TEST(SessionLife, ARegionSaysOfItsGroupHowManyAndHowFast) {
  Bench bench;
  ASSERT_TRUE(bench.core.devices().openGroup({"pair", {"test://left", "test://right"}, 2000, {}}).ok());
  auto session = bench.core.openSession("test://left", bench.administration, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok()) << toString(session.error());
  const ClientSide side(**session);
  EXPECT_EQ(side.a()->header.device_count, 2u);
  EXPECT_EQ(side.a()->header.period_ns, kMs / 2);
}

TEST(SessionLife, NobodyCanResizePunchOrMapAnewOnceSealed) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  constexpr int kExact = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  for (const Memfd* file : {&session->regions.fileA(), &session->regions.fileB()}) {
    EXPECT_EQ(fcntl(file->fd(), F_GET_SEALS) & ~0x0020 /* F_SEAL_EXEC */, kExact);
    EXPECT_NE(ftruncate(file->fd(), 4096), 0);
    EXPECT_NE(fallocate(file->fd(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096), 0);
    void* again = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, file->fd(), 0);
    EXPECT_EQ(again, MAP_FAILED);
  }
  EXPECT_NE(mprotect(const_cast<hd_region_a*>(bench.client->a()), 4096, PROT_READ | PROT_WRITE), 0);
}

TEST(SessionLife, RegionAIsNeverWritableForAClient) {
  Bench bench;
  auto session = bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok());
  EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, (*session)->regions.fileA().fd(), 0), MAP_FAILED);
}

TEST(SessionLife, HalfOpenHandshakeTimesOut) {
  Bench bench;
  auto session = bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok());
  const std::uint64_t id = (*session)->id;
  bench.step(4900);
  EXPECT_NE(bench.core.sessions().find(id), nullptr);
  bench.step(200);
  EXPECT_EQ(bench.core.sessions().find(id), nullptr);
  EXPECT_TRUE(bench.core.sessions().empty());
  EXPECT_EQ(bench.core.sessions().mapped(id).error().code, ErrorCode::kTimeout);
}

TEST(SessionLife, ADeadClientsForceFallsMonotonicallyToZeroAndNothingLeaks) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  ASSERT_TRUE(bench.arm(session->id).ok());
  std::uint64_t seq = 0;
  bench.step(40);  // the ramp
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_CLIENT_FORCE, std::as_bytes(std::span(&seq, 0)), 0, seq),
            ErrorCode::kOk);  // an empty message: refused, changes nothing
  ASSERT_EQ(bench.client->push(Vec3(1, 0, 0)), ErrorCode::kOk);
  bench.step(60);
  EXPECT_NEAR(bench.sample().force[0], 1.0, 1e-3);
  const std::uint64_t id = session->id;
  const std::uint64_t bytes = bench.core.lockedBytes();

  bench.core.disconnect(bench.connection);
  EXPECT_EQ(bench.core.sessions().find(id), nullptr);
  EXPECT_EQ(bench.client->a()->acks.ended, 1u);
  double last = bench.sample().force[0];
  int to_zero = 0;
  for (int i = 0; i < 80; ++i) {
    bench.step();
    const double now = bench.sample().force[0];
    EXPECT_LE(now, last + 1e-12) << "period " << i;
    last = now;
    if (now != 0) to_zero = i + 1;
  }
  EXPECT_EQ(last, 0.0);
  EXPECT_LE(to_zero, 55);  // 50 ms and the way of the order
  bench.step(80);
  EXPECT_TRUE(bench.core.sessions().empty());
  EXPECT_EQ(bench.device().sessions, 0u);
  EXPECT_EQ(bench.core.lockedBytes() + kSessionBytes, bytes + 0u) << "the session's memory is given back";
  for (const auto& port : bench.core.devices().links().front()->group().servo().ports) {
    if (&port != &bench.core.devices().links().front()->group().servo().ports[kClientSessions]) {
      EXPECT_EQ(port.region.load(), nullptr);
    }
  }
}

TEST(SessionLife, AnothersShareFadesOverItsTimeWhileTheDeviceStaysArmed) {
  Bench bench;
  Session* holder = bench.live();
  ASSERT_NE(holder, nullptr);
  ASSERT_TRUE(bench.arm(holder->id).ok());
  bench.step(40);
  const std::uint64_t guest = *bench.core.connect(200, 1001, false);
  auto session = bench.core.openSession("", guest, "guest", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok());
  ClientSide side(**session);
  ASSERT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
  side.producer->heartbeat(1);
  bench.step(4);
  ASSERT_EQ(side.push(Vec3(1, 0, 0)), ErrorCode::kOk);
  bench.step(60);
  ASSERT_NEAR(bench.sample().force[0], 1.0, 1e-3);

  bench.core.disconnect(guest);
  bench.step(25);
  EXPECT_GT(bench.sample().force[0], 0.2) << "it fades, it does not drop";
  EXPECT_LT(bench.sample().force[0], 0.9);
  bench.step(40);
  EXPECT_EQ(bench.sample().force[0], 0.0);
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u) << "the holder's device stays armed";
  bench.step(20);
  EXPECT_EQ(bench.core.sessions().all().size(), 1u);
}

TEST(SessionLife, ARingViolationEndsTheSession) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  const std::uint64_t id = session->id;
  std::atomic_ref<std::uint32_t>(bench.client->b()->tail).store(0x7fffffff, std::memory_order_release);
  bench.step(10);
  EXPECT_EQ(bench.core.sessions().find(id), nullptr);
  EXPECT_EQ(bench.client->a()->acks.ended, 1u);
  bench.step(150);
  EXPECT_TRUE(bench.core.sessions().empty());
}

TEST(SessionLife, SlotsAreReusedAndTheLastOneBelongsToTheMonitor) {
  Config config = Bench::relaxed();
  config.quotas.sessions = 100;
  Bench bench(config);
  std::vector<std::uint64_t> ids;
  for (std::uint32_t i = 0; i < kClientSessions; ++i) {
    auto session = bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
    ASSERT_TRUE(session.ok()) << toString(session.error());
    EXPECT_LT((*session)->slot, kClientSessions);
    ids.push_back((*session)->id);
  }
  EXPECT_EQ(bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR).error().code,
            ErrorCode::kQuotaExceeded);
  bench.core.sessions().end(ids[3], "test");
  bench.step(2);
  auto again = bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ((*again)->slot, 3u);
}

TEST(SessionLife, ConnectionsOfAllUsersLeaveRoomForStopsAndForAdministration) {
  Bench bench;
  std::size_t all = 1;  // The bench's own.
  for (std::uint32_t user = 2000; all < Clients::kConnections; ++user) {
    std::size_t own = 0;
    while (all < Clients::kConnections && own < Clients::kConnectionsPerUser) {
      const auto id = bench.core.connect(1, user, false);
      ASSERT_TRUE(id.ok());
      EXPECT_FALSE(bench.core.client(*id).stop_only);
      ++own, ++all;
    }
  }
  // Who comes then may stop devices: each user by a few connections, and nobody by those that others need.
  EXPECT_FALSE(bench.core.clients().oldestToStop(5000));
  std::vector<std::uint64_t> first;
  for (std::uint32_t user = 5000; user < 5004; ++user) {
    for (std::size_t i = 0; i < Clients::kStopOnlyPerUser; ++i) {
      const auto id = bench.core.connect(1, user, false);
      ASSERT_TRUE(id.ok());
      EXPECT_TRUE(bench.core.client(*id).stop_only);
      if (i == 0) first.push_back(*id);
    }
    EXPECT_EQ(bench.core.connect(1, user, false).error().code, ErrorCode::kQuotaExceeded);
    EXPECT_EQ(bench.core.clients().oldestToStop(user), first.back()) << "a user's own goes first";
  }
  EXPECT_EQ(bench.core.connect(1, 6000, false).error().code, ErrorCode::kQuotaExceeded);
  EXPECT_EQ(bench.core.clients().oldestToStop(6000), first.front());
  bench.core.disconnect(first.front());
  EXPECT_TRUE(bench.core.client(*bench.core.connect(1, 6000, false)).stop_only);
  for (std::size_t i = 1; i < Clients::kAdministrators; ++i) EXPECT_TRUE(bench.core.connect(1, 0, true).ok());
  EXPECT_EQ(bench.core.connect(1, 0, true).error().code, ErrorCode::kQuotaExceeded);
}

TEST(SessionLife, QuotaOfSessionsAndBytesIsPerUser) {
  Config config = Bench::relaxed();
  config.quotas.sessions = 2;
  Bench bench(config);
  const auto open = [&](std::uint64_t by) {
    return bench.core.openSession("", by, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  };
  ASSERT_TRUE(open(bench.connection).ok());
  ASSERT_TRUE(open(bench.connection).ok());
  EXPECT_EQ(open(bench.connection).error().code, ErrorCode::kQuotaExceeded);
  EXPECT_TRUE(open(*bench.core.connect(7, 1001, false)).ok()) << "another user has a quota of its own";

  config.quotas.sessions = 100;
  config.quotas.memory_mb = 2.5 * static_cast<double>(kSessionBytes) * 1e-6;
  Bench small(config);
  const std::uint64_t none = small.core.lockedBytes();
  for (int i = 0; i < 2; ++i)
    ASSERT_TRUE(small.core.openSession("", small.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR).ok());
  EXPECT_EQ(small.core.lockedBytes() - none, 2 * kSessionBytes);
  const auto refused = small.core.openSession("", small.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  EXPECT_EQ(refused.error().code, ErrorCode::kQuotaExceeded);
  EXPECT_EQ(refused.error().where, "memory");
}

/** A session that has ended counts until its force has faded. */
TEST(SessionLife, WhoOpensOneAfterTheOtherWaitsForTheRoomOfThoseThatFade) {
  Config config = Bench::relaxed();
  config.quotas.sessions = 2;
  Bench bench(config);
  const auto open = [&](std::uint64_t by, std::optional<Result<Session*>>& answer) {
    bench.core.openSession("", by, "tester", HD_SHM_MAJOR, HD_SHM_MINOR,
                           [&](const Result<Session*>& session) { answer.emplace(session); });
  };
  Session* first = bench.live();
  ASSERT_NE(first, nullptr);
  std::optional<Result<Session*>> second, third, fourth, left;
  open(bench.connection, second);
  ASSERT_TRUE(second && second->ok());
  open(bench.connection, third);
  ASSERT_TRUE(third) << "nothing ends, so there is nothing to wait for";
  EXPECT_EQ(third->error().code, ErrorCode::kQuotaExceeded);

  bench.core.sessions().end(first->id, "test");
  const std::uint64_t leaver = *bench.core.connect(100, bench.core.client(bench.connection).uid, false);
  third.reset();
  open(leaver, left);
  open(bench.connection, third);
  open(bench.connection, fourth);
  bench.step(20);
  EXPECT_FALSE(left || third || fourth) << "it fades";
  bench.core.disconnect(leaver);
  bench.step(100);
  ASSERT_TRUE(left && third && fourth);
  EXPECT_EQ(left->error().code, ErrorCode::kTimeout);
  EXPECT_TRUE(third->ok()) << "who came first";
  EXPECT_EQ(fourth->error().code, ErrorCode::kQuotaExceeded) << "nothing fades any more";
}

TEST(SessionLife, NobodyWaitsForLongNorMoreThanAFewForWhatFades) {
  Config config = Bench::relaxed();
  config.quotas.sessions = 1;
  Bench bench(config);
  const Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  bench.core.sessions().end(session->id, "test");
  std::size_t refused = 0;
  for (std::size_t i = 0; i < Core::kWishes + 1; ++i) {
    bench.core.openSession("", bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR,
                           [&](const Result<Session*>& opened) { refused += opened ? 0 : 1; });
  }
  EXPECT_EQ(refused, 1u);
  // The servo stands still: nothing fades.
  const std::int64_t until = bench.core.now() + Core::kRoomNs;
  while (bench.core.now() < until) {
    EXPECT_EQ(refused, 1u);
    bench.clock.advance(kMs);
    bench.core.poll();
  }
  EXPECT_EQ(refused, Core::kWishes + 1);
}

/** On either way, with the one of the two that is to be updated. */
TEST(SessionLife, AnotherLayoutIsRefused) {
  Bench bench;
  const auto refused = [&](std::uint16_t major, std::uint16_t minor) {
    const Error at_once = bench.core.openSession("", bench.connection, "t", major, minor).error();
    EXPECT_EQ(at_once.code, ErrorCode::kVersionMismatch);
    Error later;
    bench.core.openSession("", bench.connection, "t", major, minor,
                           [&](const Result<Session*>& session) { later = session ? Error{} : session.error(); });
    EXPECT_EQ(toString(later), toString(at_once));
    return at_once.remedy;
  };
  EXPECT_EQ(refused(HD_SHM_MAJOR + 1, 0), "update hapticd");
  EXPECT_EQ(refused(HD_SHM_MAJOR, HD_SHM_MINOR + 1), "update hapticd");
  EXPECT_EQ(refused(HD_SHM_MAJOR - 1, 0), "update the client's libhapticclient");
  EXPECT_EQ(refused(HD_SHM_MAJOR - 1, HD_SHM_MINOR + 1), "update the client's libhapticclient");
  EXPECT_TRUE(bench.core.sessions().empty());
}

TEST(SessionLife, OfADeviceThatIsNotThereThereIsNone) {
  Bench bench;
  const auto nowhere = [](std::string_view) -> Result<std::unique_ptr<Device>> {
    return Error{ErrorCode::kNotFound, "test://nowhere", "nothing has that name", {}};
  };
  bench.core.devices().setFactory(nowhere);
  std::optional<ErrorCode> answer;
  bench.core.openSession(
      "test://nowhere", bench.connection, "t", HD_SHM_MAJOR, HD_SHM_MINOR,
      [&](const Result<Session*>& session) { answer = session ? ErrorCode::kOk : session.error().code; });
  while (!answer) bench.step();
  EXPECT_EQ(*answer, ErrorCode::kNotFound);
  EXPECT_TRUE(bench.core.sessions().empty());
}

TEST(SessionLife, ADeviceWithASessionCannotBeClosed) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  EXPECT_EQ(bench.core.closeDevice("test://first", bench.connection).error().code, ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.closeDevice("test://first", bench.administration).error().code, ErrorCode::kDeviceBusy);
  bench.core.sessions().end(session->id, "test");
  EXPECT_TRUE(bench.core.closeDevice("test://first", bench.administration).ok()) << "it was never armed";
  EXPECT_TRUE(bench.core.devices().devices().empty());
  EXPECT_TRUE(bench.core.sessions().empty()) << "the one that had ended went with it";
}

}  // namespace
}  // namespace hapticd::test
