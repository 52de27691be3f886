// In which order ingest hands on what came by two ways: old must not overtake new, nor a push the client's return.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "rt/ingest/ingest.h"
#include "tests/support/random.h"
#include "tests/support/stepped/messages.h"
#include "tests/support/stepped/regions.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

/** A client that numbers its forces, and an ingest that a servo empties. */
class HandsOn : public testing::Test {
 protected:
  HandsOn() : producer_(r_.b.get(), r_.a.get()) {
    EXPECT_TRUE(ingest_.orders.push({IngestOrder::Kind::kAttach, 0, {100, r_.b.get(), r_.a.get(), 1}, 0}));
    for (std::uint32_t m = 0; m < HD_MAILBOXES; ++m) box_.emplace_back(&r_.b->mailbox[m]);
  }
  hd_client_force next() {
    hd_client_force force = test::goodForce();
    force.force[0] = ++pushed_;
    return force;
  }
  bool pushByRing() {
    if (producer_.space() == 0) return false;
    return producer_.push(HD_COMMAND_CLIENT_FORCE, test::bytesOf(next()), 0, seq_) == ErrorCode::kOk;
  }
  void pushByMailbox(std::uint32_t m) {
    ASSERT_EQ(box_[m].write(HD_COMMAND_CLIENT_FORCE, test::bytesOf(next()), seq_), ErrorCode::kOk);
  }
  /** A period: what the servo is given, in order. */
  std::vector<double> step() {
    ingest_.step(now_ += kMs, ++tick_);
    std::vector<double> taken;
    Command command;
    while (ingest_.commands.pop(command)) {
      if (command.kind == CommandKind::kClientForce) taken.push_back(command.as<hd_client_force>().force[0]);
    }
    return taken;
  }

  test::Regions r_;
  CommandProducer producer_;
  std::vector<MailboxWriter> box_;
  Ingest ingest_{IngestConfig{}};
  double pushed_ = 0;
  std::uint64_t seq_ = 0, tick_ = 1000;
  std::int64_t now_ = 5'000 * kMs;
};

TEST_F(HandsOn, TheFirstOfAMailboxComesAfterWhatStandsInTheRing) {
  constexpr int kOld = 100;
  for (int i = 0; i < kOld; ++i) ASSERT_TRUE(pushByRing());
  pushByMailbox(3);
  std::vector<double> all;
  for (int i = 0; i < 20; ++i) {
    for (const double force : step()) all.push_back(force);
  }
  ASSERT_EQ(all.size(), kOld + 1u);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
}

TEST_F(HandsOn, OneThatHasHadItsTurnWaitsForNothing) {
  pushByMailbox(3);
  EXPECT_EQ(step().size(), 1u);
  while (pushByRing()) {
  }
  pushByMailbox(3);
  const double newest = pushed_;
  const std::vector<double> taken = step();
  EXPECT_NE(std::find(taken.begin(), taken.end(), newest), taken.end());
}

TEST_F(HandsOn, OneThatWaitsIsTakenAsItIsThen) {
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(pushByRing());
  std::vector<double> all;
  for (int i = 0; i < 10; ++i) {
    pushByMailbox(3);
    all = step();
  }
  EXPECT_EQ(all, std::vector<double>{pushed_});
}

TEST_F(HandsOn, ItsTurnComesThoughTheRingIsFilledAgainAndAgain) {
  while (pushByRing()) {
  }
  const double before = pushed_;
  pushByMailbox(3);
  const double newest = pushed_;
  bool came = false;
  double last_old = 0;
  for (std::uint32_t i = 0; i < 2 * HD_RING_SLOTS && !came; ++i) {
    for (const double force : step()) {
      if (force <= before) last_old = force;
      came = came || force == newest;
      if (force == newest) {
        EXPECT_EQ(last_old, before);
      }
    }
    while (pushByRing()) {
    }
  }
  EXPECT_TRUE(came);
}

/** However pushes and periods take turns, where the ring is used first and the mailbox from some moment on. */
TEST_F(HandsOn, OldNeverOvertakesNewOfOneTarget) {
  Random random(7);
  for (std::uint32_t m = 0; m < HD_MAILBOXES; ++m) {
    const int by_ring = static_cast<int>(random.below(60));
    double last = pushed_;
    const auto look = [&] {
      for (const double force : step()) {
        EXPECT_GT(force, last) << "mailbox " << m;
        last = force;
      }
    };
    for (int i = 0; i < by_ring + 30; ++i) {
      if (i >= by_ring) {
        pushByMailbox(m);
      } else {
        ASSERT_TRUE(pushByRing());
      }
      if (random.below(8) == 0) look();
    }
    for (int i = 0; i < 20; ++i) look();
    EXPECT_EQ(last, pushed_) << "mailbox " << m;
  }
}

TEST_F(HandsOn, WhoIsBackIsBackBeforeWhatItPushes) {
  producer_.heartbeat(1);
  for (int i = 0; i < 300; ++i) step();
  producer_.heartbeat(2);
  ASSERT_TRUE(pushByRing());
  pushByMailbox(3);
  ingest_.step(now_ += kMs, ++tick_);
  std::vector<CommandKind> kinds;
  Command command;
  while (ingest_.commands.pop(command)) kinds.push_back(command.kind);
  ASSERT_GE(kinds.size(), 2u);
  EXPECT_EQ(kinds.front(), CommandKind::kReviveSession);
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), CommandKind::kReviveSession), 1);
}

}  // namespace
}  // namespace hapticd
