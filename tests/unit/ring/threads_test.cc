// Both ends at once, in two threads over one mapping: what the thread sanitizer can judge. It sees nothing across
// processes; tests/hostile does that part.
//
// The rings access shared memory by atomics alone, in which the sanitizer finds no race however wrong their order. So
// each test carries a witness: plain memory that one side writes before it publishes and the other reads after it has
// taken. If an acquire or release is missing, the sanitizer reports the witness.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>
#include <vector>

#include "rt/base/histogram.h"
#include "rt/ingest/ingest.h"
#include "tests/support/stepped/messages.h"
#include "tests/support/stepped/regions.h"

namespace hapticd {
namespace {

using test::bytesOf;
using test::payloadOf;
using test::Regions;

constexpr std::uint64_t kMessages = 20'000;
using Words = std::array<std::uint64_t, 60>;

Words wordsOf(std::uint64_t seq) {
  Words words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = seq * 0x9e3779b97f4a7c15ull + i;
  return words;
}

TEST(TwoThreads, RingLosesAndTearsNothing) {
  Regions r;
  constexpr std::uint32_t kStart = 0u - 5000;
  CommandConsumer consumer(r.b.get(), r.a.get(), kStart);
  CommandProducer producer(r.b.get(), r.a.get(), kStart);
  std::vector<std::uint64_t> pushed(kMessages + 1);  // written before the push, read after the pop: R0, A0
  std::vector<std::uint64_t> popped(kMessages + 1);  // written before the pop, read when the slot is free again: R1, A1
  std::thread client([&] {
    std::uint64_t seq = 0;
    while (seq < kMessages) {
      pushed[seq + 1] = seq + 1;
      if (producer.push(1, bytesOf(wordsOf(seq + 1)), 0, seq) != ErrorCode::kOk) {
        std::this_thread::yield();
      } else if (seq > HD_RING_SLOTS) {
        ASSERT_EQ(popped[seq - HD_RING_SLOTS], seq - HD_RING_SLOTS);
      }
    }
  });
  hd_slot copy{};
  for (std::uint64_t expected = 1; expected <= kMessages;) {
    popped[expected] = expected;
    const auto pop = consumer.pop(copy);
    if (pop == CommandConsumer::Pop::kEmpty) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(pop, CommandConsumer::Pop::kSlot);
    ASSERT_EQ(copy.seq, expected);
    ASSERT_EQ(payloadOf<Words>(copy), wordsOf(expected));
    ASSERT_EQ(pushed[expected], expected);
    ++expected;
  }
  client.join();
}

TEST(TwoThreads, MailboxIsNeverTornAndOnlyRises) {
  Regions r;
  MailboxWriter writer(&r.b->mailbox[0]);
  MailboxReader reader(&r.b->mailbox[0]);
  std::vector<std::uint64_t> written(kMessages + 1);  // R3, A3
  std::thread client([&] {
    for (std::uint64_t seq = 0; seq < kMessages;) {
      written[seq + 1] = seq + 1;
      writer.write(1, bytesOf(wordsOf(seq + 1)), seq);
      if (seq % 64 == 0) std::this_thread::yield();
    }
  });
  hd_slot copy{};
  for (std::uint64_t last = 0; last < kMessages;) {
    if (reader.read(copy) != MailboxReader::Read::kNew) continue;
    ASSERT_GT(copy.seq, last);
    ASSERT_EQ(payloadOf<Words>(copy), wordsOf(copy.seq));
    ASSERT_EQ(written[copy.seq], copy.seq);
    last = copy.seq;
  }
  client.join();
}

hd_sample wholeSample(std::uint64_t n) {
  hd_sample s{};
  s.tick = n;
  const auto x = static_cast<double>(n);
  for (double* field : {s.p, s.v, s.w, s.proxy, s.force, s.torque}) {
    for (int i = 0; i < 3; ++i) field[i] = x + i;
  }
  s.applied_commands = static_cast<std::uint32_t>(n);
  return s;
}

bool whole(const hd_sample& s) {
  hd_sample wanted = wholeSample(s.tick);
  wanted.guard = s.guard;
  return std::memcmp(&s, &wanted, sizeof wanted) == 0;
}

TEST(TwoThreads, StateIsNeverTornAndLossesAreExact) {
  Regions r;
  std::atomic<bool> done{false};
  StateReader history(r.a.get());
  const StateReader latest(r.a.get());
  std::vector<std::uint64_t> published(5 * kMessages);  // R0, A0
  std::thread servo([&] {
    StateWriter writer(r.a.get());
    for (std::uint64_t n = 0; n < 5 * kMessages; ++n) {
      published[n] = n;
      writer.publish(wholeSample(n));
      if (n % 256 == 0) std::this_thread::yield();
    }
    done = true;
  });
  std::thread other([&] {
    hd_sample s{};
    std::uint64_t last = 0;
    while (!done) {
      if (!latest.latest(0, s)) continue;
      ASSERT_TRUE(whole(s));
      ASSERT_EQ(published[s.tick], s.tick);
      ASSERT_GE(s.tick, last);
      last = s.tick;
    }
  });
  std::vector<hd_sample> out(100);
  std::uint64_t got = 0;
  std::uint64_t lost = 0;
  for (bool last_round = false; !last_round;) {
    last_round = done;
    std::uint32_t n = 0;
    do {
      n = history.drain(out, lost);
      std::uint64_t before = 0;
      for (std::uint32_t i = 0; i < n; ++i) {
        ASSERT_TRUE(whole(out[i]));
        ASSERT_EQ(published[out[i].tick], out[i].tick);
        ASSERT_TRUE(i == 0 || out[i].tick > before);
        before = out[i].tick;
      }
      got += n;
      if (n != 0) {
        ASSERT_EQ(out[n - 1].tick + 1, got + lost);
      }
    } while (n != 0);
  }
  servo.join();
  other.join();
  EXPECT_EQ(got + lost, 5 * kMessages);
}

TEST(TwoThreads, IngestServesAClientThreadAndAServoThread) {
  Regions r;
  Ingest ingest{IngestConfig{}};
  ASSERT_TRUE(ingest.orders.push({IngestOrder::Kind::kAttach, 0, {1, r.b.get(), r.a.get(), 1}}));
  std::thread client([&] {
    CommandProducer producer(r.b.get(), r.a.get());
    std::uint64_t seq = 0;
    while (seq < kMessages) {
      producer.heartbeat(static_cast<std::int64_t>(seq));
      if (producer.push(HD_COMMAND_CLIENT_FORCE, bytesOf(test::goodForce()), 0, seq) != ErrorCode::kOk) {
        std::this_thread::yield();
      }
    }
  });
  std::thread servo([&] {
    Command command;
    for (std::uint64_t expected = 1; expected <= kMessages;) {
      if (!ingest.commands.pop(command)) {
        std::this_thread::yield();
        continue;
      }
      if (command.kind != CommandKind::kClientForce) continue;  // lost and revived, when the client got no CPU time
      ASSERT_EQ(command.seq, expected++);
    }
  });
  for (std::uint64_t tick = 1; __atomic_load_n(&r.a->acks.received_seq, __ATOMIC_RELAXED) < kMessages; ++tick) {
    ingest.step(static_cast<std::int64_t>(tick), tick);
    std::this_thread::yield();
  }
  client.join();
  servo.join();
}

TEST(TwoThreads, HistogramIsReadAndResetWhileItIsWritten) {
  Histogram h;
  std::atomic<bool> done{false};
  std::thread reader([&] {
    while (!done) {
      const auto s = h.summary();
      ASSERT_LE(s.p50_ns, s.max_ns);
      h.requestReset();
      std::this_thread::yield();
    }
  });
  for (std::uint64_t i = 0; i < kMessages; ++i) h.record(static_cast<std::int64_t>(i));
  done = true;
  reader.join();
}

}  // namespace
}  // namespace hapticd
