#include "rt/ingest/ingest.h"

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "tests/support/stepped/messages.h"
#include "tests/support/stepped/regions.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

using test::bytesOf;
using Kind = IngestReport::Kind;

/** A client with both ends of its session, attached to an ingest. */
struct Client {
  Client(Ingest& ingest, std::uint32_t slot_, std::uint32_t start = 0)
      : slot(slot_), producer(r.b.get(), r.a.get(), start) {
    EXPECT_TRUE(ingest.orders.push({IngestOrder::Kind::kAttach, slot, {100 + slot, r.b.get(), r.a.get(), 1}, start}));
    for (std::uint32_t m = 0; m < HD_MAILBOXES; ++m) mailbox.emplace_back(&r.b->mailbox[m]);
  }
  template <class T>
  ErrorCode push(std::uint32_t kind, const T& payload, std::uint64_t at_tick = 0) {
    return producer.push(kind, bytesOf(payload), at_tick, seq);
  }
  ErrorCode pushForce(double fx = 1) {
    hd_client_force force = test::goodForce();
    force.force[0] = fx;
    return push(HD_COMMAND_CLIENT_FORCE, force);
  }
  const hd_acks& acks() const { return r.a->acks; }

  std::uint32_t slot;
  test::Regions r;
  CommandProducer producer;
  std::vector<MailboxWriter> mailbox;
  std::uint64_t seq = 0;
};

class IngestTest : public testing::Test {
 protected:
  void step(std::int64_t dt_ns = kMs) {
    now += dt_ns;
    ++tick;
    ingest.step(now, tick);
  }
  /** What the servo takes in one tick. */
  std::vector<Command> servo(std::uint32_t most = kIngestCommandsPerCycle) {
    std::vector<Command> taken;
    Command command;
    while (taken.size() < most && ingest.commands.pop(command)) taken.push_back(command);
    return taken;
  }
  std::vector<IngestReport> reports() {
    std::vector<IngestReport> all;
    IngestReport report;
    while (ingest.reports.pop(report)) all.push_back(report);
    return all;
  }

  IngestConfig config;
  Ingest ingest{config};
  std::int64_t now = 5'000 * kMs;
  std::uint64_t tick = 1000;
};

TEST_F(IngestTest, PassesCheckedCommandsInOrderAndAcknowledges) {
  Client client(ingest, 3, 0xfffffffdu);
  for (int i = 0; i < 5; ++i) ASSERT_EQ(client.pushForce(i), ErrorCode::kOk);
  step();
  const auto taken = servo();
  ASSERT_EQ(taken.size(), 5u);
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(taken[i].kind, CommandKind::kClientForce);
    EXPECT_EQ(taken[i].session, 3u);
    EXPECT_EQ(taken[i].channel, 0u);
    EXPECT_EQ(taken[i].seq, i + 1u);
    EXPECT_EQ(taken[i].as<hd_client_force>().force[0], i);
  }
  EXPECT_EQ(client.acks().received_seq, 5u);
  EXPECT_EQ(client.acks().ring_head, 2u) << "wrapped";
  EXPECT_EQ(client.acks().rejected, 0u);
  EXPECT_EQ(client.producer.space(), HD_RING_SLOTS);
}

TEST_F(IngestTest, EveryKindPasses) {
  Client client(ingest, 0);
  for (const test::Message& m : test::goodMessages()) {
    std::uint64_t seq = 0;
    ASSERT_EQ(client.producer.push(m.slot.kind, std::as_bytes(std::span(m.slot.payload, m.slot.length)), 0, seq),
              ErrorCode::kOk);
    step();
    const auto taken = servo();
    ASSERT_EQ(taken.size(), 1u) << m.name;
    EXPECT_EQ(static_cast<std::uint32_t>(taken[0].kind), m.slot.kind);
  }
}

TEST_F(IngestTest, BudgetBoundsEachStep) {
  Client client(ingest, 0);
  for (int i = 0; i < 200; ++i) ASSERT_EQ(client.pushForce(), ErrorCode::kOk);
  step();
  EXPECT_EQ(servo().size(), config.budget_per_session);
  step();
  EXPECT_EQ(servo().size(), config.budget_per_session);
  EXPECT_EQ(client.acks().ring_head, 2 * config.budget_per_session);
}

TEST_F(IngestTest, ServoAwayLosesNothingAndNeverBlocks) {
  Client client(ingest, 0);
  std::uint64_t sent = 0;
  while (client.pushForce() == ErrorCode::kOk) ++sent;
  for (int i = 0; i < 100; ++i) step();  // nobody takes
  EXPECT_LE(ingest.commands.size(), kIngestCommandsPerCycle);
  std::uint64_t expected = 1;
  for (int i = 0; i < 100; ++i) {
    for (const Command& command : servo()) ASSERT_EQ(command.seq, expected++);
    step();
  }
  EXPECT_EQ(expected - 1, sent);
  EXPECT_EQ(client.acks().rejected, 0u);
}

// Fifteen sessions flood; the sixteenth's commands reach the servo in the tick after they were pushed, all of them.
TEST_F(IngestTest, FloodDelaysOnlyItsSender) {
  std::vector<std::unique_ptr<Client>> flood;
  for (std::uint32_t s = 1; s < kMaxSessions; ++s) flood.push_back(std::make_unique<Client>(ingest, s));
  Client honest(ingest, 0);
  std::map<std::uint32_t, std::uint64_t> passed;
  for (int i = 0; i < 500; ++i) {
    honest.producer.heartbeat(i);
    for (auto& client : flood) {
      client->producer.heartbeat(i);
      while (client->pushForce() == ErrorCode::kOk) {
      }
      std::uint64_t seq = 0;
      for (auto& box : client->mailbox) box.write(HD_COMMAND_CLIENT_FORCE, bytesOf(test::goodForce()), seq);
    }
    ASSERT_EQ(honest.pushForce(), ErrorCode::kOk);
    ASSERT_EQ(honest.pushForce(), ErrorCode::kOk);
    std::uint64_t seq = 0;
    ASSERT_EQ(honest.mailbox[0].write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq), ErrorCode::kOk);
    step();
    std::uint32_t own = 0;
    for (const Command& command : servo()) {
      ++passed[command.session];
      own += command.session == 0 ? 1 : 0;
    }
    ASSERT_EQ(own, 3u) << "step " << i;
    ASSERT_EQ(ingest.commands.size(), 0u);
  }
  for (const auto& [session, n] : passed) EXPECT_EQ(n, 500u * limits::kFairShare) << session;
}

// What the servo's tick has over when each has had its fair share goes round, whatever slots they have, and who idles.
TEST_F(IngestTest, WhatIsOverIsSharedOutInTurns) {
  std::vector<std::unique_ptr<Client>> greedy, idle, content;
  for (const std::uint32_t s : {0u, 1u, 4u, 5u, 11u}) greedy.push_back(std::make_unique<Client>(ingest, s));
  for (const std::uint32_t s : {2u, 9u}) idle.push_back(std::make_unique<Client>(ingest, s));
  for (const std::uint32_t s : {3u, 7u, 8u}) content.push_back(std::make_unique<Client>(ingest, s));
  std::map<std::uint32_t, double> passed;
  constexpr int kSteps = 20 * kMaxSessions;
  for (int i = 0; i < kSteps; ++i) {
    for (auto& client : idle) client->producer.heartbeat(i);
    for (auto& client : content) {
      client->producer.heartbeat(i);
      ASSERT_EQ(client->pushForce(), ErrorCode::kOk);
    }
    for (auto& client : greedy) {
      client->producer.heartbeat(i);
      while (client->pushForce() == ErrorCode::kOk) {
      }
    }
    step();
    for (const Command& command : servo()) ++passed[command.session];
  }
  // 16 is a session's budget, 48 the tick's: three of five have more than their share in a step, and in turns.
  EXPECT_EQ(passed.size(), greedy.size() + content.size());
  for (const auto& client : content) {
    const std::uint32_t session = client->slot;
    EXPECT_EQ(passed[session], kSteps) << session;
    passed.erase(session);
  }
  for (const auto& [session, n] : passed) EXPECT_NEAR(n, (kIngestCommandsPerCycle - 3) / 5.0 * kSteps, 20) << session;
}

TEST_F(IngestTest, SequenceMustRise) {
  Client client(ingest, 0);
  for (int i = 0; i < 4; ++i) client.pushForce();
  client.r.b->ring[1].seq = 1;  // again
  client.r.b->ring[2].seq = 0;
  client.r.b->ring[3].seq = 9;  // gaps are the client's business
  step();
  const auto taken = servo();
  ASSERT_EQ(taken.size(), 2u);
  EXPECT_EQ(taken[0].seq, 1u);
  EXPECT_EQ(taken[1].seq, 9u);
  EXPECT_EQ(client.acks().rejected, 2u);
  EXPECT_EQ(client.acks().last_rejected_seq, 0u);
  EXPECT_EQ(client.acks().last_rejected_code, static_cast<std::uint32_t>(ErrorCode::kInvalidArgument));
  EXPECT_EQ(client.acks().received_seq, 9u);
}

TEST_F(IngestTest, RejectionsAreCountedAndReportedAtALimitedRate) {
  Client client(ingest, 2);
  hd_client_force bad = test::goodForce();
  bad.lease_ns = 0;
  std::uint64_t rejected = 0;
  std::uint64_t told = 0;
  std::vector<IngestReport> all;
  for (int i = 0; i < 3500; ++i) {
    client.producer.heartbeat(i);
    while (rejected < client.acks().rejected + 3) {
      ASSERT_EQ(client.push(HD_COMMAND_CLIENT_FORCE, bad), ErrorCode::kOk);
      ++rejected;
    }
    step();
    ASSERT_EQ(client.acks().rejected, rejected);
    ASSERT_EQ(client.acks().last_rejected_seq, client.seq);
    ASSERT_EQ(client.acks().last_rejected_channel, 0u);
    for (const IngestReport& report : reports()) {
      ASSERT_EQ(report.kind, Kind::kRejected);
      EXPECT_EQ(report.slot, 2u);
      EXPECT_EQ(report.code, static_cast<std::uint32_t>(ErrorCode::kInvalidArgument));
      told += 1 + report.suppressed;
      ASSERT_EQ(told, client.acks().rejected);
      all.push_back(report);
    }
  }
  EXPECT_EQ(all.size(), 4u) << "one at once, then one a second";
  EXPECT_TRUE(servo().empty());
  EXPECT_EQ(client.acks().violations, 0u);
}

TEST_F(IngestTest, CommandsMayBeSentAheadWithinBounds) {
  Client client(ingest, 0);
  step();
  ASSERT_EQ(client.push(HD_COMMAND_LIMITS, test::goodLimits(), tick + 2 + config.max_ahead_ticks), ErrorCode::kOk);
  ASSERT_EQ(client.push(HD_COMMAND_LIMITS, test::goodLimits(), UINT64_MAX), ErrorCode::kOk);
  step();
  EXPECT_EQ(client.acks().rejected, 2u);
  for (std::uint32_t i = 0; i < limits::kWaitingPerSession + 2; ++i) {
    ASSERT_EQ(client.push(HD_COMMAND_LIMITS, test::goodLimits(), tick + 6), ErrorCode::kOk);
  }
  ASSERT_EQ(client.push(HD_COMMAND_LIMITS, test::goodLimits(), 1), ErrorCode::kOk) << "the past is at once";
  step();
  EXPECT_EQ(servo().size(), limits::kWaitingPerSession + 1);
  EXPECT_EQ(client.acks().rejected, 4u);
  EXPECT_EQ(client.acks().last_rejected_code, static_cast<std::uint32_t>(ErrorCode::kQuotaExceeded));
  ASSERT_EQ(client.push(HD_COMMAND_LIMITS, test::goodLimits(), tick + 1), ErrorCode::kOk) << "the present, too";
  step();
  EXPECT_EQ(servo().size(), 1u);
  for (int i = 0; i < 3; ++i) step();
  ASSERT_EQ(client.push(HD_COMMAND_LIMITS, test::goodLimits(), tick + 1 + config.max_ahead_ticks), ErrorCode::kOk);
  step();  // their tick has come
  EXPECT_EQ(servo().size(), 1u);
  EXPECT_EQ(client.acks().rejected, 4u);
}

TEST_F(IngestTest, MailboxesAreLatestWinsWithTheirOwnNumbers) {
  Client client(ingest, 1);
  std::uint64_t seq = 0;
  for (int i = 1; i <= 3; ++i) {
    hd_client_force force = test::goodForce();
    force.force[0] = i;
    ASSERT_EQ(client.mailbox[4].write(HD_COMMAND_CLIENT_FORCE, bytesOf(force), seq), ErrorCode::kOk);
  }
  client.r.b->mailbox[4].at_tick = UINT64_MAX;
  ASSERT_EQ(client.mailbox[15].write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq), ErrorCode::kOk);
  step();
  auto taken = servo();
  ASSERT_EQ(taken.size(), 2u);
  EXPECT_EQ(taken[0].channel, 5u);
  EXPECT_EQ(taken[0].seq, 3u);
  EXPECT_EQ(taken[0].as<hd_client_force>().force[0], 3.0);
  EXPECT_EQ(taken[0].at_tick, 0u) << "whatever the client says";
  EXPECT_EQ(taken[1].channel, 16u);
  EXPECT_EQ(taken[1].seq, 1u);
  EXPECT_EQ(client.acks().received_seq, 0u) << "that one speaks of the ring";
  step();
  EXPECT_TRUE(servo().empty());
  client.r.b->mailbox[4].guard += 2;  // rewritten with the same number
  step();
  EXPECT_TRUE(servo().empty());
  EXPECT_EQ(client.acks().rejected, 1u);
  EXPECT_EQ(client.acks().last_rejected_channel, 5u);
  EXPECT_EQ(client.acks().last_rejected_seq, 3u);
  const auto told = reports();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].channel, 5u);
  EXPECT_EQ(told[0].seq, 3u);
}

TEST_F(IngestTest, MailboxLeftHalfWrittenCountsAsStaleAndHurtsNoOther) {
  Client client(ingest, 1);
  std::uint64_t seq = 0;
  client.r.b->mailbox[0].guard = 1;
  client.mailbox[1].write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq);
  step();
  EXPECT_EQ(servo().size(), 1u);
  EXPECT_EQ(client.acks().stale_mailboxes, 1u);
  EXPECT_EQ(client.acks().rejected, 0u) << "what was copied last is not taken for it";
}

TEST_F(IngestTest, NeitherRingNorMailboxesStarveTheOther) {
  Client client(ingest, 0);
  std::uint64_t seq = 0;
  std::uint32_t ring = 0;
  std::map<std::uint32_t, std::uint32_t> boxes;
  for (auto& box : client.mailbox) box.write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq);
  step();  // Their first messages come after what stands in the ring.
  EXPECT_EQ(servo().size(), HD_MAILBOXES);
  for (int i = 0; i < 20; ++i) {
    while (client.pushForce() == ErrorCode::kOk) {
    }
    for (auto& box : client.mailbox) box.write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq);
    step();
    for (const Command& command : servo()) ++(command.channel == 0 ? ring : boxes[command.channel]);
  }
  EXPECT_EQ(ring, 20 * config.budget_per_session / 2);
  EXPECT_EQ(boxes.size(), HD_MAILBOXES);
  for (const auto& [box, n] : boxes) EXPECT_EQ(n, 10u) << box;
}

TEST_F(IngestTest, AnEmptyRingCostsTheMailboxesNothing) {
  Client client(ingest, 0);
  std::uint64_t seq = 0;
  for (auto& box : client.mailbox) box.write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq);
  step();
  EXPECT_EQ(servo().size(), HD_MAILBOXES);
}

TEST_F(IngestTest, ViolationLosesTheSessionForGoodAndIsReportedOnce) {
  Client client(ingest, 6);
  Client other(ingest, 7);
  client.pushForce();
  client.r.b->tail = 1000;
  std::uint64_t seq = 0;
  for (int i = 0; i < 1000; ++i) {
    client.producer.heartbeat(i);
    other.producer.heartbeat(i);
    client.r.b->tail = 1;
    client.mailbox[0].write(HD_COMMAND_INTENT, bytesOf(test::goodIntent()), seq);
    if (i == 0) {
      client.r.b->tail = 1000;
    }
    ASSERT_EQ(other.pushForce(), ErrorCode::kOk);
    step();
    bool lost = false;
    std::uint32_t others = 0;
    for (const Command& command : servo()) {
      if (command.kind == CommandKind::kLoseSession) {
        lost = true;
        EXPECT_EQ(command.as<SessionRef>().slot, 6u);
        EXPECT_EQ(command.as<SessionRef>().id, 106u);
        EXPECT_EQ(command.session, kControlSession);
      } else {
        EXPECT_EQ(command.session, 7u);
        ++others;
      }
    }
    ASSERT_EQ(lost, i == 0);
    ASSERT_EQ(others, 1u);
  }
  const auto all = reports();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].kind, Kind::kViolation);
  EXPECT_EQ(all[0].slot, 6u);
  EXPECT_EQ(client.acks().violations, 1u);
}

TEST_F(IngestTest, SilentHeartbeatLosesAndItsReturnRevives) {
  Client client(ingest, 5);
  client.producer.heartbeat(1);
  step();
  for (int i = 0; i < 200; ++i) step();
  EXPECT_TRUE(servo().empty());
  step();
  auto taken = servo();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].kind, CommandKind::kLoseSession);
  EXPECT_EQ(taken[0].as<SessionRef>().slot, 5u);
  EXPECT_EQ(client.acks().heartbeat_age_ns, 201 * kMs);
  for (int i = 0; i < 10; ++i) step();
  EXPECT_TRUE(servo().empty());
  client.producer.heartbeat(-7);  // any change counts, whatever the client's clock says
  step();
  taken = servo();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].kind, CommandKind::kReviveSession);
  const auto all = reports();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].kind, Kind::kStale);
  EXPECT_EQ(all[1].kind, Kind::kAlive);
}

/** However often it has beaten before. */
TEST_F(IngestTest, AHeartbeatIsAsOldAsItsLastChange) {
  Client client(ingest, 5);
  const std::int64_t stale = config.stale_after_ns / kMs;
  std::int64_t beat = 0;
  for (const std::int64_t pause : {std::int64_t{1}, std::int64_t{7}, stale, stale + 1, std::int64_t{3}, stale + 5}) {
    client.producer.heartbeat(++beat);
    step();
    EXPECT_EQ(client.acks().heartbeat_age_ns, 0);
    servo();
    for (std::int64_t age = 1; age <= pause; ++age) {
      step();
      ASSERT_EQ(client.acks().heartbeat_age_ns, age * kMs);
      const auto taken = servo();
      ASSERT_EQ(taken.size(), age == stale + 1 ? 1u : 0u) << "lost after " << age << " of " << pause;
      if (!taken.empty()) {
        EXPECT_EQ(taken[0].kind, CommandKind::kLoseSession);
      }
    }
  }
}

TEST_F(IngestTest, OfAHeartbeatThatCameAndWentUnreadOnlyTheLastIsReported) {
  Client client(ingest, 0);
  step();
  while (ingest.reports.push(IngestReport{})) {
  }
  for (int i = 0; i < 300; ++i) step();
  client.producer.heartbeat(1);
  for (int i = 0; i < 300; ++i) step();
  reports();
  step();
  const auto all = reports();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].kind, Kind::kStale);
}

TEST_F(IngestTest, FullOutletsLoseNoOrderAndNoReport) {
  Client client(ingest, 0);
  step();
  while (ingest.commands.push(Command{})) {
  }
  while (ingest.reports.push(IngestReport{})) {
  }
  for (int i = 0; i < 300; ++i) step();  // stale meanwhile
  servo(1000);
  reports();
  step();
  const auto taken = servo();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].kind, CommandKind::kLoseSession);
  const auto all = reports();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].kind, Kind::kStale);
}

TEST_F(IngestTest, DetachIsConfirmedAndTheSlotStartsAfresh) {
  {
    Client client(ingest, 4);
    client.pushForce();
    step();
    EXPECT_EQ(servo().size(), 1u);
    client.pushForce();
    ASSERT_TRUE(ingest.orders.push({IngestOrder::Kind::kDetach, 4, {}}));
    step();
    EXPECT_TRUE(servo().empty());
    const auto all = reports();
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].kind, Kind::kDetached);
    EXPECT_EQ(all[0].slot, 4u);
  }
  step();  // the regions are gone; the address sanitizer would see a use
  Client next(ingest, 4);
  next.pushForce();
  step();
  const auto taken = servo();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].seq, 1u);
}

TEST_F(IngestTest, OrdersForSlotsThatDoNotExistAreIgnored) {
  ASSERT_TRUE(ingest.orders.push({IngestOrder::Kind::kDetach, kMaxSessions, {}}));
  ASSERT_TRUE(ingest.orders.push({IngestOrder::Kind::kAttach, 0xffffffff, {}}));
  step();
  EXPECT_TRUE(reports().empty());
}

// The slot is scribbled on as soon as ingest has stepped: the command is what was there before.
TEST_F(IngestTest, ChangesAfterTheCopyHaveNoEffect) {
  Client client(ingest, 0);
  client.pushForce(2.5);
  step();
  std::memset(static_cast<void*>(client.r.b->ring), 0xff, sizeof client.r.b->ring);
  const auto taken = servo();
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].as<hd_client_force>().force[0], 2.5);
  EXPECT_EQ(taken[0].as<hd_client_force>().lease_ns, test::goodForce().lease_ns);
}

}  // namespace
}  // namespace hapticd
