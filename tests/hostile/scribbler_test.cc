// Clients that write nonsense while an honest one works on the same ingest: bounded work, typed refusals, and every
// honest command in the very next tick.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <set>

#include "rt/ingest/ingest.h"
#include "tests/hostile/attacker.h"
#include "tests/support/random.h"
#include "tests/support/stepped/messages.h"
#include "tests/support/stepped/regions.h"

namespace hapticd {
namespace {

using test::Attacker;
using test::SharedRegions;
using Kind = IngestReport::Kind;

constexpr std::uint32_t kHostile = 3;
constexpr std::uint32_t kHonest = 9;
// At least the first; until the attack has shown enough; at most the second, for machines with much else to do.
constexpr auto kShortest = std::chrono::milliseconds(300);
constexpr auto kLongest = std::chrono::seconds(30);

/** A word of everything: bits, small numbers, and what a parser trips over. */
std::uint64_t nasty(Random& random) {
  switch (random.below(5)) {
    case 0:
      return random.bits();
    case 1:
      return random.below(20);
    case 2:
      return std::uint64_t{0x7ff8000000000000};  // NaN
    case 3:
      return ~std::uint64_t{0};
    default:
      return std::uint64_t{0x3ff0000000000000};  // 1.0
  }
}

/**
 * Overwrites a slot by a good message, then spoils a few of its words. The number stays as given: one huge number would
 * be the last that is ever taken, and nothing would be tested after it.
 */
void scribbleSlot(hd_slot& slot, Random& random, const hd_slot& good, std::uint64_t seq) {
  auto* words = reinterpret_cast<volatile std::uint64_t*>(&slot);
  const auto* source = reinterpret_cast<const std::uint64_t*>(&good);
  for (std::size_t i = 1; i < sizeof slot / 8; ++i) words[i] = source[i];
  reinterpret_cast<volatile std::uint32_t*>(&slot)[1] = good.kind;
  words[2] = seq;
  for (int n = random.below(6); n > 0; --n) {
    const std::uint32_t at = 1 + random.below(std::uint32_t{sizeof slot / 8 - 1});
    if (at != 2) words[at] = nasty(random);
  }
}

class Scribbler : public testing::Test {
 protected:
  Scribbler() : producer(honest.b.get(), honest.a.get()) {
    for (const test::Message& m : test::goodMessages()) good[good_count++] = m.slot;
    attach(kHonest, honest.a.get(), honest.b.get());
    attach(kHostile, shared.a(), shared.b());
  }

  void attach(std::uint32_t slot, hd_region_a* a, hd_region_b* b) {
    const std::uint32_t start = slot == kHostile ? __atomic_load_n(&b->tail, __ATOMIC_ACQUIRE) : 0;
    ASSERT_TRUE(ingest.orders.push({IngestOrder::Kind::kAttach, slot, {slot, b, a, 1}, start}));
    attached = true;
  }

  /** One tick: the honest client pushes, ingest steps, the servo takes. Checks all that must hold in each. */
  void cycle() {
    hd_client_force force = test::goodForce();
    force.force[0] = static_cast<double>(tick % 900);
    std::uint64_t seq = 0;
    ASSERT_EQ(producer.push(HD_COMMAND_CLIENT_FORCE, test::bytesOf(force), 0, seq), ErrorCode::kOk);
    producer.heartbeat(static_cast<std::int64_t>(tick));
    const std::uint32_t head = shared.a()->acks.ring_head;
    ++tick;
    now += 1'000'000;
    ingest.step(now, tick);
    if (!attached) most_popped = std::max(most_popped, shared.a()->acks.ring_head - head);
    attached = false;
    std::uint32_t honest_taken = 0;
    std::uint32_t taken = 0;
    Command command;
    while (ingest.commands.pop(command)) {
      ++taken;
      if (command.session == kHonest) {
        ++honest_taken;
        ASSERT_EQ(command.seq, seq);
        ASSERT_EQ(command.as<hd_client_force>().force[0], force.force[0]);
      } else if (command.session == kHostile) {
        ++accepted;
        kinds.insert(static_cast<std::uint32_t>(command.kind));
        expectValid(command);
      } else {
        ASSERT_EQ(command.session, kControlSession);
        losses += command.kind == CommandKind::kLoseSession ? 1 : 0;
      }
    }
    ASSERT_EQ(honest_taken, 1u) << "an honest command passes in its own tick";
    ASSERT_LE(taken, kIngestCommandsPerCycle + kMaxSessions);
    IngestReport report;
    while (ingest.reports.pop(report)) {
      ASSERT_EQ(report.slot, kHostile);
      ++reports[static_cast<std::uint32_t>(report.kind)];
    }
    ++cycles;
  }

  /** What passed the check passes it again. */
  static void expectValid(const Command& command) {
    hd_slot again{};
    again.kind = static_cast<std::uint32_t>(command.kind);
    std::memcpy(again.payload, command.payload, sizeof again.payload);
    for (const test::Message& m : test::goodMessages()) {
      if (m.slot.kind == again.kind) again.length = m.slot.length;
    }
    Command out;
    ASSERT_EQ(validate(again, 1, out), ErrorCode::kOk) << "kind " << again.kind;
  }

  template <class Each, class Enough>
  void run(Each each, Enough enough) {
    const auto start = std::chrono::steady_clock::now();
    for (auto spent = start - start; spent < kLongest && !HasFatalFailure() && (spent < kShortest || !enough());
         spent = std::chrono::steady_clock::now() - start) {
      cycle();
      each();
    }
    EXPECT_TRUE(enough()) << "the attack showed too little";
    EXPECT_LE(most_popped, config.budget_per_session);
    EXPECT_EQ(honest.a->acks.rejected, 0u);
    EXPECT_EQ(honest.a->acks.violations, 0u);
    EXPECT_EQ(honest.a->acks.received_seq, cycles);
  }

  IngestConfig config;
  Ingest ingest{config};
  SharedRegions shared;
  test::Regions honest;
  CommandProducer producer;
  std::array<hd_slot, 16> good{};
  std::uint32_t good_count = 0;
  std::uint64_t tick = 0;
  std::int64_t now = 0;
  std::uint64_t cycles = 0;
  std::uint64_t accepted = 0;
  std::uint64_t losses = 0;
  std::uint32_t most_popped = 0;
  bool attached = false;  ///< An attachment moved the head.
  std::set<std::uint32_t> kinds;
  std::array<std::uint64_t, static_cast<std::size_t>(Kind::kKinds)> reports{};
  [[nodiscard]] std::uint64_t reported(Kind kind) const { return reports[static_cast<std::size_t>(kind)]; }
};

TEST_F(Scribbler, OfIndicesIsCaughtEveryTimeAndHarmsNobody) {
  Random random(seedOf(1));
  Attacker attacker([&] {
    hd_region_b* b = shared.b();
    *const_cast<volatile std::uint32_t*>(&b->tail) = static_cast<std::uint32_t>(random.bits());
    *const_cast<volatile std::int64_t*>(&b->heartbeat_ns) = static_cast<std::int64_t>(random.bits());
    scribbleSlot(b->ring[random.below(HD_RING_SLOTS)], random, good[random.below(good_count)], random.bits());
  });
  std::uint64_t violations = 0;
  run(
      [&] {
        if (__atomic_load_n(&shared.a()->acks.violations, __ATOMIC_RELAXED) == 0) return;
        // The daemon would end the session here. The next one finds the same attacker at work.
        ++violations;
        shared.a()->acks.violations = 0;
        ASSERT_TRUE(ingest.orders.push({IngestOrder::Kind::kDetach, kHostile, {}}));
        attach(kHostile, shared.a(), shared.b());
      },
      [&] { return violations > 100; });
  EXPECT_TRUE(attacker.kill()) << "it was at work to the end";
  EXPECT_EQ(reported(Kind::kViolation), violations);
  EXPECT_GE(losses, violations) << "each was told to the servo";
  EXPECT_LE(losses, violations + reported(Kind::kStale)) << "and once; an attacker without CPU time may go stale";
}

TEST_F(Scribbler, OfSlotsBehindPlausibleTailsIsRefusedSlotBySlot) {
  Random random(seedOf(2));
  std::uint32_t tail = 0;
  std::uint64_t seq = 0;
  Attacker attacker([&] {
    hd_region_b* b = shared.b();
    for (int i = 0; i < 8; ++i) {
      // Slots at the consumer's end are overwritten again and again, while they are being read.
      const std::uint32_t at = random.below(2) == 0 ? tail + random.below(8) : random.below(HD_RING_SLOTS);
      scribbleSlot(b->ring[at % HD_RING_SLOTS], random, good[random.below(good_count)], seq += random.below(3));
    }
    const std::uint32_t fill = tail - __atomic_load_n(&shared.a()->acks.ring_head, __ATOMIC_ACQUIRE);
    tail += random.below(HD_RING_SLOTS - fill + 1);
    __atomic_store_n(&b->tail, tail, __ATOMIC_RELEASE);
    *const_cast<volatile std::int64_t*>(&b->heartbeat_ns) = static_cast<std::int64_t>(random.bits());
  });
  const hd_acks& acks = shared.a()->acks;
  run([] {}, [&] { return acks.rejected > 1000 && accepted > 100 && kinds.size() == HD_COMMAND_KINDS - 1u; });
  EXPECT_TRUE(attacker.kill());
  EXPECT_EQ(acks.violations, 0u) << "the tails were plausible, so the decoder was what was attacked";
  EXPECT_GE(reported(Kind::kRejected), 1u);
  EXPECT_LE(reported(Kind::kRejected), 2 + static_cast<std::uint64_t>(now / Ingest::kReportIntervalNs));
}

TEST_F(Scribbler, OfMailboxesIsRefusedOrSkipped) {
  Random random(seedOf(3));
  std::uint64_t seq = 0;
  Attacker attacker([&] {
    hd_slot& box = shared.b()->mailbox[random.below(HD_MAILBOXES)];
    scribbleSlot(box, random, good[random.below(good_count)], ++seq);
    *const_cast<volatile std::uint32_t*>(&box.guard) = static_cast<std::uint32_t>(random.bits());
    *const_cast<volatile std::int64_t*>(&shared.b()->heartbeat_ns) = static_cast<std::int64_t>(random.bits());
  });
  const hd_acks& acks = shared.a()->acks;
  run([] {}, [&] { return acks.rejected > 1000 && acks.stale_mailboxes > 100 && accepted > 100; });
  EXPECT_TRUE(attacker.kill());
  EXPECT_EQ(acks.violations, 0u);
  EXPECT_EQ(acks.ring_head, 0u);
}

}  // namespace
}  // namespace hapticd
