/** @file
 * What crosses between a client and the daemon, under every reordering: the command ring, the mailboxes, the states.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"
#include "tests/model/weak_memory.h"
#include "tests/support/seeds.h"
#include "tests/support/stepped/regions.h"

namespace hapticd::model {
namespace {

using test::bytesOf;
using test::payloadOf;
using test::Regions;

// The slots are written as they are, not atomically: what is asked is whether each side may count on the other.
TEST(WeakRings, ACommandIsReadWhenItIsWrittenAndOverwrittenWhenItIsRead) {
  constexpr std::uint32_t kFree = 1, kPushes = 4;  // The ring is nearly full.
  Regions r;
  std::uint32_t most_pushed = 0;
  const Found found = exploreSome(20'000, seedOf(1), [&](Threads& threads) {
    threads.plain(r.b->ring, sizeof r.b->ring);
    CommandProducer producer(r.b.get(), r.a.get());
    CommandConsumer consumer(r.b.get(), r.a.get());
    std::uint64_t seq = 0;
    for (std::uint64_t n = 0; n < HD_RING_SLOTS - kFree; ++n) (void)producer.push(1, bytesOf(n), 0, seq);
    std::array<Mark, HD_RING_SLOTS + kPushes> written{}, read{};
    std::uint64_t pushed = HD_RING_SLOTS - kFree, popped = 0;
    const std::uint64_t before = pushed;
    threads.add([&] {
      for (std::uint32_t turn = 0; turn < kPushes; ++turn) {
        written[pushed] = threads.mark();
        if (producer.push(1, bytesOf(pushed), 0, seq) != ErrorCode::kOk) continue;
        threads.expect(pushed < HD_RING_SLOTS || threads.knowsMoreThan(read[pushed - HD_RING_SLOTS]),
                       "written before it was read");
        ++pushed;
      }
    });
    threads.add([&] {
      hd_slot copy;
      for (std::uint32_t turn = 0; turn < HD_RING_SLOTS + kPushes; ++turn) {
        const Mark mark = threads.mark();
        if (consumer.pop(copy) != CommandConsumer::Pop::kSlot) continue;
        threads.expect(payloadOf<std::uint64_t>(copy) == popped && copy.seq == popped + 1, "out of order");
        threads.expect(popped < before || threads.knowsMoreThan(written[popped]), "read before it was written");
        read[popped++] = mark;
      }
    });
    threads.go();
    most_pushed = std::max(most_pushed, static_cast<std::uint32_t>(pushed - before));
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_EQ(most_pushed, kPushes) << "some run must use a slot again";
}

// Write n has kind, length and every word of it tell so.
TEST(WeakRings, AMailboxIsReadWholeOrNotAtAll) {
  constexpr std::uint32_t kWrites = 3;
  const auto isWhole = [](const hd_slot& slot) {
    const auto words = payloadOf<std::array<std::uint64_t, kWrites>>(slot);
    return slot.kind == slot.seq && slot.length == 8 * slot.seq &&
           std::all_of(words.begin(), words.begin() + slot.seq, [&](std::uint64_t word) { return word == slot.seq; });
  };
  Regions r;
  std::array<int, 3> reads{};
  const Found found = exploreSome(100'000, seedOf(1), [&](Threads& threads) {
    r.b->mailbox[0] = {};
    MailboxWriter writer(&r.b->mailbox[0]);
    MailboxReader reader(&r.b->mailbox[0]);
    threads.add([&] {
      std::uint64_t seq = 0;
      for (std::uint32_t n = 1; n <= kWrites; ++n) {
        const std::array<std::uint64_t, kWrites> words{n, n, n};
        (void)writer.write(n, bytesOf(words).first(8 * n), seq);
      }
    });
    threads.add([&] {
      hd_slot copy{};
      std::uint64_t last = 0;
      for (int turn = 0; turn < 4; ++turn) {
        const MailboxReader::Read read = reader.read(copy);
        ++reads[static_cast<std::size_t>(read)];
        if (read != MailboxReader::Read::kNew) continue;
        threads.expect(isWhole(copy), "torn");
        threads.expect(copy.seq > last, "older than the last");
        last = copy.seq;
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  for (const int count : reads) EXPECT_GT(count, 0);
}

// The newest of a target by a mailbox must not come before what it was told by the ring.
TEST(WeakRings, WhoFindsAMailboxKnowsWhatTheRingWasGivenBefore) {
  Regions r;
  int found_both = 0;
  const Found found = exploreSome(20'000, seedOf(1), [&](Threads& threads) {
    r.b->mailbox[0] = {};
    CommandProducer producer(r.b.get(), r.a.get());
    const CommandConsumer consumer(r.b.get(), r.a.get());
    MailboxWriter writer(&r.b->mailbox[0]);
    MailboxReader reader(&r.b->mailbox[0]);
    threads.add([&] {
      std::uint64_t seq = 0;
      const std::uint64_t word = 1;
      (void)producer.push(1, bytesOf(word), 0, seq);
      (void)writer.write(1, bytesOf(word), seq);
    });
    threads.add([&] {
      hd_slot copy{};
      for (int turn = 0; turn < 2; ++turn) {
        if (reader.read(copy) != MailboxReader::Read::kNew) continue;
        threads.expect(consumer.pushed() == 1, "the mailbox came first");
        ++found_both;
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_GT(found_both, 0);
}

/** Sample n of a device, each word of which tells so. */
hd_sample sampleOf(std::uint64_t n, std::uint32_t device) {
  hd_sample sample{};
  sample.tick = n;
  sample.device = device;
  sample.t_ns = static_cast<std::int64_t>(n);
  sample.p[0] = sample.q[3] = sample.v[1] = sample.proxy[2] = sample.force[0] = sample.gripper_rad =
      static_cast<double>(n);
  sample.depth_m = sample.own[2] = static_cast<float>(n);
  sample.missed = static_cast<std::uint32_t>(n);
  return sample;
}
bool isWhole(hd_sample sample) {
  const hd_sample whole = sampleOf(sample.tick, sample.device);
  sample.guard = 0;
  return std::memcmp(&sample, &whole, sizeof whole) == 0;
}

/** A new history. */
void clear(hd_region_a& a) {
  std::memset(static_cast<void*>(a.latest), 0, sizeof a.latest);
  std::memset(static_cast<void*>(a.history), 0, sizeof a.history);
  a.history_tail = 0;
}

TEST(WeakRings, TheLatestSampleIsAlwaysThereWholeAndNeverOlderThanTheLast) {
  Regions r({.device_count = 2});
  const Found found = exploreSome(6'000, seedOf(1), [&](Threads& threads) {
    clear(*r.a);
    StateWriter writer(r.a.get());
    const StateReader reader(r.a.get());
    const auto publish = [&](std::uint64_t n) {
      writer.publish(sampleOf(n, 0));
      writer.publish(sampleOf(n, 1));
    };
    publish(1);
    threads.add([&] {
      for (std::uint64_t n = 2; n <= 4; ++n) publish(n);
    });
    threads.add([&] {
      std::uint64_t last = 0;
      for (int turn = 0; turn < 3; ++turn) {
        hd_sample sample;
        threads.expect(reader.latest(0, sample), "not found");
        threads.expect(isWhole(sample) && sample.device == 0, "torn");
        threads.expect(sample.tick >= last, "older than the last");
        last = sample.tick;
      }
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
}

/** Reads while samples `before`, `before` + 1, ... are published; what comes is whole, in order, or counted as lost. */
Found drainWhile(std::uint64_t before, std::uint64_t read_before, std::uint64_t more, std::uint64_t& most_lost) {
  Regions r;
  return exploreSome(2'000, seedOf(1), [&](Threads& threads) {
    clear(*r.a);
    StateWriter writer(r.a.get());
    for (std::uint64_t n = 0; n < read_before; ++n) writer.publish(sampleOf(n, 0));
    StateReader reader(r.a.get());
    for (std::uint64_t n = read_before; n < before; ++n) writer.publish(sampleOf(n, 0));
    threads.add([&] {
      for (std::uint64_t n = before; n < before + more; ++n) writer.publish(sampleOf(n, 0));
    });
    std::uint64_t next = read_before, got = 0, lost = 0;
    const auto drain = [&](std::span<hd_sample> some) {
      const std::uint32_t count = reader.drain(some, lost);
      for (const hd_sample& sample : some.first(count)) {
        threads.expect(isWhole(sample), "torn");
        threads.expect(sample.tick >= next, "out of order");
        next = sample.tick + 1;
      }
      got += count;
    };
    threads.add([&] {
      std::array<hd_sample, 3> some;
      for (int turn = 0; turn < 3; ++turn) drain(some);
    });
    threads.go();
    std::vector<hd_sample> rest(2 * HD_HISTORY_SLOTS);
    drain(rest);
    threads.expect(next == before + more, "the last is missed");
    threads.expect(got + lost == before + more - read_before, "lost and not counted, or counted and not lost");
    most_lost = std::max(most_lost, lost);
  });
}

TEST(WeakRings, AHistoryLosesNothingToAReaderThatKeepsUp) {
  std::uint64_t most_lost = 0;
  EXPECT_EQ(drainWhile(2, 2, 4, most_lost).failure, "");
  EXPECT_EQ(most_lost, 0u);
}

TEST(WeakRings, AHistoryThatOverflowsIsReadWholeAndCounted) {
  std::uint64_t most_lost = 0;
  EXPECT_EQ(drainWhile(HD_HISTORY_SLOTS - 1, 0, 4, most_lost).failure, "");
  EXPECT_GT(most_lost, 0u) << "some run must be lapped";
  EXPECT_LE(most_lost, 3u);
}

}  // namespace
}  // namespace hapticd::model
