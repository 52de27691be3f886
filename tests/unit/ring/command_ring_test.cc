#include "rt/ring/command_ring.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <deque>
#include <random>

#include "tests/support/seeds.h"
#include "tests/support/stepped/regions.h"

namespace hapticd {
namespace {

using test::bytesOf;
using test::payloadOf;
using test::Regions;
using Pop = CommandConsumer::Pop;

// Indices that wrap during each test, and those of every real session.
class CommandRing : public testing::TestWithParam<std::uint32_t> {
 protected:
  CommandRing() : producer(r.b.get(), r.a.get(), GetParam()), consumer(r.b.get(), r.a.get(), GetParam()) {}
  ErrorCode push(std::uint64_t value) { return producer.push(HD_COMMAND_INTENT, bytesOf(value), value + 7, seq); }

  Regions r;
  CommandProducer producer;
  CommandConsumer consumer;
  hd_slot slot{};
  std::uint64_t seq = 0;
};
INSTANTIATE_TEST_SUITE_P(Start, CommandRing, testing::Values(0u, 0xfffffffdu));

TEST_P(CommandRing, IsEmptyAtFirst) {
  EXPECT_EQ(consumer.pop(slot), Pop::kEmpty);
  EXPECT_EQ(producer.space(), HD_RING_SLOTS);
}

TEST_P(CommandRing, CarriesOneSlot) {
  ASSERT_EQ(push(42), ErrorCode::kOk);
  EXPECT_EQ(seq, 1u);
  ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
  EXPECT_EQ(slot.kind, HD_COMMAND_INTENT);
  EXPECT_EQ(slot.length, 8u);
  EXPECT_EQ(slot.seq, 1u);
  EXPECT_EQ(slot.at_tick, 49u);
  EXPECT_EQ(payloadOf<std::uint64_t>(slot), 42u);
  EXPECT_EQ(consumer.pop(slot), Pop::kEmpty);
}

TEST_P(CommandRing, FullWouldBlockAndLosesNothing) {
  for (std::uint64_t i = 0; i < HD_RING_SLOTS; ++i) ASSERT_EQ(push(i), ErrorCode::kOk);
  EXPECT_EQ(producer.space(), 0u);
  EXPECT_EQ(push(999), ErrorCode::kWouldBlock);
  EXPECT_EQ(seq, HD_RING_SLOTS) << "a refused push takes no number";
  ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
  EXPECT_EQ(push(HD_RING_SLOTS), ErrorCode::kOk);
  for (std::uint64_t i = 1; i <= HD_RING_SLOTS; ++i) {
    ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
    ASSERT_EQ(payloadOf<std::uint64_t>(slot), i);
    ASSERT_EQ(slot.seq, i + 1);
  }
  EXPECT_EQ(consumer.pop(slot), Pop::kEmpty);
}

TEST_P(CommandRing, TakesWholePayloadAndNoMore) {
  std::array<std::byte, sizeof(hd_slot::payload) + 1> big;
  for (std::size_t i = 0; i < big.size(); ++i) big[i] = static_cast<std::byte>(i * 7);
  EXPECT_EQ(producer.push(1, big, 0, seq), ErrorCode::kInvalidArgument);
  EXPECT_EQ(producer.space(), HD_RING_SLOTS);
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{13}, sizeof(hd_slot::payload)}) {
    ASSERT_EQ(producer.push(1, std::span(big).first(size), 0, seq), ErrorCode::kOk);
    ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
    ASSERT_EQ(slot.length, size);
    EXPECT_EQ(std::memcmp(slot.payload, big.data(), size), 0);
  }
}

TEST_P(CommandRing, ImpossibleFillIsAViolationForGood) {
  ASSERT_EQ(push(1), ErrorCode::kOk);
  for (const std::uint32_t tail : {GetParam() + HD_RING_SLOTS + 1, GetParam() - 1, GetParam() + 0x80000000u}) {
    CommandConsumer victim(r.b.get(), r.a.get(), GetParam());
    r.b->tail = tail;
    EXPECT_EQ(victim.pop(slot), Pop::kViolation);
    r.b->tail = GetParam() + 1;
    EXPECT_EQ(victim.pop(slot), Pop::kViolation) << "a liar is not believed again";
  }
  r.b->tail = GetParam() + HD_RING_SLOTS;
  EXPECT_EQ(consumer.pop(slot), Pop::kSlot) << "a full ring is none";
}

TEST_P(CommandRing, LengthBeyondTheSlotCopiesNoMoreThanTheSlot) {
  ASSERT_EQ(push(1), ErrorCode::kOk);
  r.b->ring[GetParam() % HD_RING_SLOTS].length = 0xffffffffu;
  std::array<hd_slot, 2> copies{};
  std::memset(copies.data(), 0xa5, sizeof copies);
  const hd_slot untouched = copies[1];
  ASSERT_EQ(consumer.pop(copies[0]), Pop::kSlot);
  EXPECT_EQ(copies[0].length, 0xffffffffu) << "kept for validate() to refuse";
  EXPECT_EQ(std::memcmp(&copies[1], &untouched, sizeof untouched), 0);
}

// What the producer wrote is what the copy holds, whatever happens to the slot afterwards.
TEST_P(CommandRing, ChangesAfterTheCopyHaveNoEffect) {
  ASSERT_EQ(push(5), ErrorCode::kOk);
  ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
  std::memset(static_cast<void*>(&r.b->ring[GetParam() % HD_RING_SLOTS]), 0xff, sizeof(hd_slot));
  EXPECT_EQ(payloadOf<std::uint64_t>(slot), 5u);
  EXPECT_EQ(slot.length, 8u);
}

// A slot is used anew every 256 commands, and the daemon refuses one whose reserved word is not zero.
TEST_P(CommandRing, WhatStoodInASlotIsGone) {
  hd_slot& used = r.b->ring[GetParam() % HD_RING_SLOTS];
  std::memset(static_cast<void*>(&used), 0xff, sizeof used);
  ASSERT_EQ(producer.push(HD_COMMAND_INTENT, {}, 0, seq), ErrorCode::kOk);
  std::memset(static_cast<void*>(&slot), 0xff, sizeof slot);
  ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
  EXPECT_EQ(slot.length, 0u);
  EXPECT_EQ(slot.reserved, 0u);
  EXPECT_EQ(slot.at_tick, 0u);
  ASSERT_EQ(push(1), ErrorCode::kOk);
  r.b->ring[(GetParam() + 1) % HD_RING_SLOTS].reserved = 9;
  ASSERT_EQ(consumer.pop(slot), Pop::kSlot);
  EXPECT_EQ(slot.reserved, 9u) << "for validate() to see";
}

// A head that the daemon cannot have written leaves no room, rather than more than there is.
TEST_P(CommandRing, AnImpossibleHeadLeavesNoSpace) {
  ASSERT_EQ(push(1), ErrorCode::kOk);
  for (const std::uint32_t beyond : {1u, 2u, 1000u}) {
    r.a->acks.ring_head = GetParam() + 1 + beyond;
    EXPECT_EQ(producer.space(), 0u) << beyond;
  }
  r.a->acks.ring_head = GetParam() + 1;
  EXPECT_EQ(producer.space(), HD_RING_SLOTS);
}

TEST_P(CommandRing, BehavesAsAQueueUnderRandomUse) {
  std::mt19937 random(seedOf(20240501 + GetParam()));
  std::deque<std::pair<std::uint64_t, std::uint64_t>> model;  // seq, value
  std::uint64_t next = 0;
  std::uint32_t bias = 50;
  for (int i = 0; i < 200'000; ++i) {
    if (i % 1000 == 0) bias = random() % 101;  // runs of mostly pushing, then of mostly popping
    if (random() % 100 < bias) {
      const ErrorCode code = push(next);
      ASSERT_EQ(code, model.size() == HD_RING_SLOTS ? ErrorCode::kWouldBlock : ErrorCode::kOk);
      if (code == ErrorCode::kOk) model.emplace_back(seq, next++);
    } else {
      const Pop pop = consumer.pop(slot);
      ASSERT_EQ(pop, model.empty() ? Pop::kEmpty : Pop::kSlot);
      if (pop != Pop::kSlot) continue;
      ASSERT_EQ(slot.seq, model.front().first);
      ASSERT_EQ(payloadOf<std::uint64_t>(slot), model.front().second);
      model.pop_front();
    }
    ASSERT_EQ(producer.space(), HD_RING_SLOTS - model.size());
  }
  EXPECT_GT(next, 10 * HD_RING_SLOTS);
}

TEST(Mailbox, LatestWins) {
  Regions r;
  MailboxWriter writer(&r.b->mailbox[3]);
  MailboxReader reader(&r.b->mailbox[3]);
  hd_slot copy{};
  std::uint64_t seq = 0;
  EXPECT_EQ(reader.read(copy), MailboxReader::Read::kSame);
  for (std::uint64_t value = 1; value <= 3; ++value) ASSERT_EQ(writer.write(8, bytesOf(value), seq), ErrorCode::kOk);
  ASSERT_EQ(reader.read(copy), MailboxReader::Read::kNew);
  EXPECT_EQ(payloadOf<std::uint64_t>(copy), 3u);
  EXPECT_EQ(copy.seq, 3u);
  EXPECT_EQ(copy.kind, 8u);
  EXPECT_EQ(reader.read(copy), MailboxReader::Read::kSame);
}

TEST(Mailbox, HalfWrittenIsBusyAndKeepsWhatWas) {
  Regions r;
  hd_slot& box = r.b->mailbox[0];
  MailboxWriter writer(&box);
  MailboxReader reader(&box);
  hd_slot copy{};
  std::uint64_t seq = 0;
  ASSERT_EQ(writer.write(8, bytesOf(seq), seq), ErrorCode::kOk);
  ASSERT_EQ(reader.read(copy), MailboxReader::Read::kNew);
  box.guard = 3;
  EXPECT_EQ(reader.read(copy), MailboxReader::Read::kBusy);
  box.guard = 4;
  EXPECT_EQ(reader.read(copy), MailboxReader::Read::kNew);
}

TEST(Mailbox, WhatStoodInItIsGone) {
  Regions r;
  hd_slot& box = r.b->mailbox[0];
  std::memset(static_cast<void*>(&box), 0xff, sizeof box);
  box.guard = 0;
  MailboxWriter writer(&box);
  MailboxReader reader(&box);
  const std::array<std::byte, 11> payload{std::byte{1}, std::byte{2}};
  std::uint64_t seq = 0;
  hd_slot copy{};
  ASSERT_EQ(writer.write(8, payload, seq), ErrorCode::kOk);
  ASSERT_EQ(reader.read(copy), MailboxReader::Read::kNew);
  EXPECT_EQ(copy.length, 11u);
  EXPECT_EQ(copy.reserved, 0u);
  EXPECT_EQ(copy.at_tick, 0u);
  EXPECT_EQ(std::memcmp(copy.payload, payload.data(), 11), 0);
  for (std::size_t i = 11; i < 16; ++i) EXPECT_EQ(copy.payload[i], 0) << i << ": the last word is filled up with zeros";
}

TEST(Mailbox, RefusesTooLong) {
  Regions r;
  MailboxWriter writer(&r.b->mailbox[0]);
  std::uint64_t seq = 0;
  const std::array<std::byte, sizeof(hd_slot::payload) + 1> big{};
  EXPECT_EQ(writer.write(8, big, seq), ErrorCode::kInvalidArgument);
  EXPECT_EQ(r.b->mailbox[0].guard, 0u);
}

}  // namespace
}  // namespace hapticd
