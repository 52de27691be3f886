// What becomes of a device when the client that had it opened is gone: what is simulated, and nobody else's, closes.
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

constexpr const char* kUri = "sim://default?mass=0.3";

struct Leaving : testing::Test {
  void open(const char* uri, std::uint64_t connection) {
    const auto opened = bench.core.openDevice(uri, connection);
    ASSERT_TRUE(opened.ok()) << toString(opened.error());
  }
  /** A session on kUri whose client has mapped it; live some periods later. */
  Session* join(std::uint64_t connection) {
    const auto session = bench.core.openSession(kUri, connection, "guest", HD_SHM_MAJOR, HD_SHM_MINOR);
    EXPECT_TRUE(session.ok()) << toString(session.error());
    bench.client = std::make_unique<ClientSide>(**session);
    EXPECT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
    bench.step(4);
    return *session;
  }
  /** Ends the client, and waits longer than any fade. */
  void leave(std::uint64_t connection) {
    bench.client.reset();
    bench.core.disconnect(connection);
    bench.step(200);
  }
  [[nodiscard]] bool isOpen(const char* uri = kUri) {
    const auto& all = bench.core.devices().devices();
    return std::any_of(all.begin(), all.end(), [&](const auto& d) { return d->info().uri == uri; });
  }
  /** The force last sent to the second device [N]. */
  [[nodiscard]] double sent() const { return bench.scripted.back()->sent.back().force.norm(); }

  /** A session of that client pushes with 1 N, which takes 200 ms to go: longer than its session takes. */
  std::uint64_t push(std::uint64_t connection) {
    const Session* session = join(connection);
    EXPECT_TRUE(bench.arm(session->id).ok());
    bench.step(50);
    GuardLimits limits = bench.device(1).limits;
    limits.force_slew = kSlew;
    EXPECT_TRUE(bench.core.setLimits(kUri, limits, connection).ok());
    EXPECT_EQ(bench.client->push(Vec3(1, 0, 0)), ErrorCode::kOk);
    bench.step(400);
    EXPECT_NEAR(sent(), 1.0, 1e-3);
    return session->id;
  }
  /** Steps tick by tick, and calls `each` after it: the force falls no faster than it may, and is zero at the end. */
  template <class Each>
  void untilClosed(Each&& each) {
    double before = sent();
    int ticks = 0;
    for (; isOpen() && ticks < 500; ++ticks) {
      for (const auto& link : bench.core.devices().links()) link->group().step();
      EXPECT_LE(sent(), before) << "tick " << ticks;
      EXPECT_LE(before - sent(), kSlew * 1e-3 * (1 + 1e-9)) << "tick " << ticks;
      before = sent();
      bench.core.poll();
      each();
    }
    EXPECT_LT(ticks, 500);
    EXPECT_EQ(before, 0.0) << "the device was closed on a hand that felt a force";
  }
  static constexpr double kSlew = 5;  ///< [N/s]
  Bench bench;
  const std::uint64_t mine = *bench.core.connect(102, 1001, false);
  const std::uint64_t other = *bench.core.connect(103, 1002, false);
};

TEST_F(Leaving, WhatAClientAloneHadOpenedCloses) {
  const std::uint64_t listener = bench.core.events().subscribe(0, [] {});
  open(kUri, mine);
  bench.step(50);
  ASSERT_TRUE(isOpen()) << "while its client is there";
  leave(mine);
  EXPECT_FALSE(isOpen());
  EXPECT_EQ(bench.core.devices().links().size(), 1u) << "its servo goes too";
  EXPECT_TRUE(isOpen("test://first")) << "what nobody asked for is not this client's";
  const auto heard = bench.core.events().take(listener).events;
  EXPECT_EQ(std::count_if(heard.begin(), heard.end(),
                          [](const Event& e) { return e.kind == EventKind::kDeviceRemoved && e.device == "sim"; }),
            1);
  open(kUri, other);  // And it can be had again.
  EXPECT_TRUE(isOpen());
}

TEST_F(Leaving, OnlyWhenTheHandFeelsNothingAnyMore) {
  push(mine);
  bench.core.disconnect(mine);
  bench.client.reset();
  untilClosed([] {});
}

/** Neither by its client nor by an administrator. */
TEST_F(Leaving, NobodyClosesItWhileTheHandFeelsAForce) {
  for (const std::uint64_t by : {mine, bench.administration}) {
    const std::uint64_t session = push(mine);
    bench.core.sessions().end(session, "test");
    bench.client.reset();
    int refused = 0;
    untilClosed([&] {
      const auto closed = bench.core.closeDevice(kUri, by);
      if (closed) return;
      EXPECT_EQ(closed.error().code, ErrorCode::kWouldBlock);
      ++refused;
    });
    EXPECT_GT(refused, 150) << "200 ms of it";
  }
}

/** A program that ends its session and closes its device, each at once, need not ask again and again. */
TEST_F(Leaving, WhoClosesItMayWaitUntilItsForceIsLowered) {
  const std::uint64_t session = push(mine);
  std::vector<Result<void>> heard;
  const auto ask = [&](std::uint64_t by) {
    bench.core.onceLowered(
        by, [this, by] { return bench.core.closeDevice(kUri, by); },
        [&](const Result<void>& closed) { heard.push_back(closed); });
  };
  ask(mine);
  ASSERT_EQ(heard.size(), 1u) << "a session uses it";
  EXPECT_EQ(heard.back().error().code, ErrorCode::kDeviceBusy);
  bench.core.sessions().end(session, "test");
  bench.client.reset();
  ask(mine);
  untilClosed([&] { EXPECT_EQ(heard.size(), isOpen() ? 1u : 2u); });
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_TRUE(heard.back().ok()) << toString(heard.back().error());
}

TEST_F(Leaving, WhatAClientAsksForMeanwhileIsDoneInItsOrder) {
  const std::uint64_t session = push(mine);
  bench.core.sessions().end(session, "test");
  bench.client.reset();
  std::vector<int> done;
  bool lowers = true;
  const auto ask = [&](std::uint64_t by, int number) {
    bench.core.onceLowered(
        by,
        [&] {
          return lowers ? Result<void>(Error{ErrorCode::kWouldBlock, {}, {}, {}}) : Result<void>();
        },
        [&done, number](const Result<void>& result) { done.push_back(result ? number : -number); });
  };
  ask(mine, 1);
  lowers = false;  // Before the next poll().
  ask(mine, 2);
  EXPECT_TRUE(done.empty()) << "the first still waits";
  ask(other, 3);
  EXPECT_EQ(done, std::vector{3}) << "another client does not";
  bench.core.poll();
  EXPECT_EQ(done, (std::vector{3, 1, 2}));
}

TEST_F(Leaving, NobodyWaitsLongForAServoThatStandsStill) {
  const std::uint64_t session = push(mine);
  bench.core.sessions().end(session, "test");
  bench.client.reset();
  std::optional<ErrorCode> heard;
  int attempts = 0;
  const auto ask = [&](std::uint64_t by) {
    heard.reset();
    attempts = 0;
    bench.core.onceLowered(
        by,
        [&] {
          ++attempts;
          return Result<void>(Error{ErrorCode::kWouldBlock, {}, {}, {}});
        },
        [&](const Result<void>& closed) { heard = closed ? ErrorCode::kOk : closed.error().code; });
  };
  ask(mine);
  int waited = 0;  // [ms]
  for (; !heard && waited < 3000; ++waited, bench.clock.advance(kMs)) bench.core.poll();
  EXPECT_EQ(heard, ErrorCode::kWouldBlock);
  EXPECT_NEAR(waited, 2000, 2);
  ask(other);
  EXPECT_FALSE(heard);
  bench.core.disconnect(other);
  bench.core.poll();
  EXPECT_EQ(heard, ErrorCode::kTimeout);
  EXPECT_EQ(attempts, 1) << "it has left";
}

TEST_F(Leaving, AnAdministratorWaitsTwoSecondsForAServoThatStandsStill) {
  for (const int ms : {0, 150}) {  // Its session has not been let go, or has.
    const std::uint64_t session = push(mine);
    bench.core.sessions().end(session, "test");
    bench.client.reset();
    bench.step(ms);
    ASSERT_NE(sent(), 0.0);
    ASSERT_EQ(bench.device(1).sessions, ms == 0 ? 1u : 0u);
    int waited = ms;  // [ms]
    for (; waited < 3000; ++waited, bench.clock.advance(kMs)) {
      bench.core.poll();
      const auto closed = bench.core.closeDevice(kUri, bench.administration);
      if (closed) break;
      ASSERT_EQ(closed.error().code, ErrorCode::kWouldBlock);
      ASSERT_EQ(bench.core.closeDevice(kUri, mine).error().code, ErrorCode::kWouldBlock);
    }
    EXPECT_NEAR(waited, 2000, 2);
    EXPECT_FALSE(isOpen());
    EXPECT_TRUE(bench.core.sessions().empty());
  }
}

TEST(LeavingAGroup, NoDeviceOfItIsClosedWhileTheHandOnAnotherFeelsAForce) {
  Bench bench(Bench::relaxed(), 2);
  const Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(50);
  GuardLimits limits = bench.device().limits;
  limits.force_slew = 5;  // [N/s]
  ASSERT_TRUE(bench.core.setLimits("test://first", limits, bench.connection).ok());
  ASSERT_EQ(bench.client->push(Vec3(1, 0, 0)), ErrorCode::kOk);
  bench.step(400);
  const auto sent = [&] { return bench.scripted.front()->sent.back().force.norm(); };
  ASSERT_NEAR(sent(), 1.0, 1e-3);
  const auto close = [&] { return bench.core.closeDevice("test://second", bench.administration); };
  EXPECT_EQ(close().error().what, "a session uses it");
  bench.core.sessions().end(session->id, "test");
  bench.client.reset();
  double last = 1;
  int refused = 0;
  for (; refused < 500; ++refused) {
    bench.step();
    last = sent();
    const auto closed = close();
    if (closed) break;
    EXPECT_EQ(closed.error().where, bench.device().name);
  }
  EXPECT_EQ(last, 0.0);
  EXPECT_NEAR(refused, 200, 10);
}

TEST_F(Leaving, NotWhileOthersWantIt) {
  open(kUri, mine);
  open(kUri, other);
  leave(mine);
  ASSERT_TRUE(isOpen()) << "the other has asked for it, too";
  const Session* session = join(other);
  EXPECT_NE(session, nullptr);
  leave(other);
  EXPECT_FALSE(isOpen()) << "the last one has left";
}

TEST_F(Leaving, NotWhileItIsRecorded) {
  open(kUri, mine);
  auto recording = bench.core.record(kUri, other);
  ASSERT_TRUE(recording.ok()) << toString(recording.error());
  leave(mine);
  ASSERT_TRUE(isOpen());
  bench.core.recordings().drop(recording->id);
  for (int i = 0; i < 5000 && isOpen(); ++i) {
    bench.step();
    ::usleep(1000);
  }
  EXPECT_FALSE(isOpen());
}

TEST_F(Leaving, NotWhatIsConfiguredRealOrAnAdministrators) {
  for (const char* uri : {"test://first", "falcon://default", kUri}) open(uri, mine);
  open(kUri, bench.administration);  // Later than the client, and yet.
  open("sim://touch", bench.administration);
  leave(mine);
  leave(bench.administration);
  for (const char* uri : {"test://first", "falcon://default", kUri, "sim://touch"}) EXPECT_TRUE(isOpen(uri)) << uri;
}

TEST_F(Leaving, WhatWasStillBeingOpenedCloses) {
  int answers = 0;
  for (const std::uint64_t connection : {mine, bench.administration}) {
    const char* uri = connection == mine ? kUri : "sim://touch";
    bench.core.openDevice(uri, connection, [&](const Result<OpenDevice*>& device) { answers += device.ok() ? 1 : 0; });
    bench.core.disconnect(connection);
  }
  for (int i = 0; i < 10'000 && (answers < 2 || isOpen()); ++i) {
    bench.step();
    ::usleep(1000);
  }
  EXPECT_EQ(answers, 2);
  EXPECT_FALSE(isOpen());
  EXPECT_TRUE(isOpen("sim://touch")) << "an administrator's stays";
}

TEST_F(Leaving, ASessionThatEndsAloneLeavesItsClientTheDevice) {
  const Session* session = join(mine);
  bench.core.sessions().end(session->id, "test");
  bench.client.reset();
  bench.step(200);
  EXPECT_TRUE(isOpen()) << "its client may want to open a session again";
  leave(mine);
  EXPECT_FALSE(isOpen());
}

}  // namespace
}  // namespace hapticd::test
