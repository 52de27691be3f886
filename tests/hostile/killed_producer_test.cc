// Producers killed at random instants: whatever they were doing, no torn and no out-of-order message is ever taken.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstring>

#include "rt/ring/command_ring.h"
#include "tests/hostile/attacker.h"
#include "tests/support/random.h"

namespace hapticd {
namespace {

using test::Attacker;
using test::SharedRegions;

constexpr int kKills = 400;
constexpr std::size_t kWords = sizeof(hd_slot::payload) / 8;
constexpr std::uint32_t kRingKind = 1;
constexpr std::uint32_t kMailboxKind = 2;
using Payload = std::array<std::uint64_t, kWords>;

/** Every word depends on the number and on its place, so that no mixture of two messages passes. */
Payload payloadOf(std::uint64_t seq, std::uint32_t kind) {
  Payload payload;
  for (std::size_t i = 0; i < kWords; ++i) payload[i] = (seq * 0x9e3779b97f4a7c15ull) ^ (i << 32) ^ kind;
  return payload;
}

/** True if the copy is exactly what the producer wrote under that number. */
bool whole(const hd_slot& copy, std::uint32_t kind) {
  const Payload wanted = payloadOf(copy.seq, kind);
  return copy.kind == kind && copy.length == sizeof wanted && copy.reserved == 0 &&
         copy.at_tick == (kind == kRingKind ? copy.seq * 3 : 0) &&
         std::memcmp(copy.payload, wanted.data(), sizeof wanted) == 0;
}

TEST(KilledProducer, LeavesNoTornAndNoDisorderedMessage) {
  SharedRegions shared;
  Random random(seedOf(400));
  std::uint64_t messages = 0;
  std::uint64_t boxes = 0;
  int killed_while_full = 0;
  int killed_in_mailbox = 0;
  for (int n = 0; n < kKills; ++n) {
    shared.reset();
    // In one of four the consumer is slow, so that the producer also dies at a full ring.
    const bool slow = n % 4 == 0;
    CommandConsumer consumer(shared.b(), shared.a());
    MailboxReader mailbox(&shared.b()->mailbox[0]);
    CommandProducer producer(shared.b(), shared.a());
    MailboxWriter writer(&shared.b()->mailbox[0]);
    std::uint64_t next = 1;
    std::uint64_t next_box = 1;
    std::uint64_t seq = 0;
    Attacker child([&] {
      const Payload message = payloadOf(next, kRingKind);
      if (producer.push(kRingKind, std::as_bytes(std::span(message)), next * 3, seq) == ErrorCode::kOk) ++next;
      const Payload state = payloadOf(next_box++, kMailboxKind);
      writer.write(kMailboxKind, std::as_bytes(std::span(state)), seq);
    });

    hd_slot copy{};
    std::uint64_t expected = 1;
    std::uint64_t last_box = 0;
    const auto take = [&] {
      const auto pop = consumer.pop(copy);
      if (pop == CommandConsumer::Pop::kEmpty) return false;
      EXPECT_EQ(pop, CommandConsumer::Pop::kSlot);
      EXPECT_EQ(copy.seq, expected);
      EXPECT_TRUE(whole(copy, kRingKind)) << "kill " << n << ", message " << copy.seq;
      ++expected;
      return !testing::Test::HasFailure();
    };
    const auto look = [&] {
      if (mailbox.read(copy) != MailboxReader::Read::kNew) return;
      EXPECT_GT(copy.seq, last_box);
      EXPECT_TRUE(whole(copy, kMailboxKind)) << "kill " << n << ", mailbox " << copy.seq;
      last_box = copy.seq;
      ++boxes;
    };
    const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(random.below(5000));
    while (std::chrono::steady_clock::now() < end) {
      if (!slow || random.below(64) == 0) take();
      look();
    }
    killed_while_full += __atomic_load_n(&shared.b()->tail, __ATOMIC_ACQUIRE) - (expected - 1) == HD_RING_SLOTS;
    ASSERT_TRUE(child.kill());
    killed_in_mailbox += static_cast<int>(shared.b()->mailbox[0].guard & 1u);
    while (take()) {
    }
    look();
    messages += expected - 1;
    ASSERT_EQ(shared.b()->tail, static_cast<std::uint32_t>(expected - 1)) << "all that was pushed came";
    ASSERT_FALSE(HasFailure());
  }
  // The test is worth nothing if the children did nothing, or died only between messages.
  EXPECT_GT(messages, 10u * kKills);
  EXPECT_GT(boxes, 0u);
  EXPECT_GT(killed_while_full, 0);
  EXPECT_GT(killed_in_mailbox, 0);
  RecordProperty("messages", std::to_string(messages));
}

}  // namespace
}  // namespace hapticd
