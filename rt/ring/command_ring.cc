#include "rt/ring/command_ring.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "rt/ring/shared.h"

namespace hapticd {
namespace {

constexpr std::size_t kPayloadBytes = sizeof(hd_slot::payload);
constexpr std::uint32_t kSlotMask = HD_RING_SLOTS - 1;
static_assert((HD_RING_SLOTS & kSlotMask) == 0, "the capacity divides 2^32");
static_assert(offsetof(hd_slot, payload) % 8 == 0 && kPayloadBytes % 8 == 0, "slots are copied by words");

/** Everything but the guard, for a mailbox: the reader may look at any moment. The last word is filled up with zeros.
 */
void writeMailbox(hd_slot& slot, std::uint32_t kind, std::span<const std::byte> payload, std::uint64_t seq) HD_RT {
  storeRelease(slot.kind, kind);
  storeRelease(slot.length, static_cast<std::uint32_t>(payload.size()));
  storeRelease(slot.reserved, 0u);
  storeRelease(slot.seq, seq);
  storeRelease(slot.at_tick, std::uint64_t{0});
  auto* out = reinterpret_cast<SharedWord*>(slot.payload);
  for (std::size_t i = 0; i < payload.size(); i += 8) {
    std::uint64_t word = 0;  // the caller's bytes may stand anywhere
    std::memcpy(&word, payload.data() + i, std::min<std::size_t>(8, payload.size() - i));
    __atomic_store_n(out++, word, __ATOMIC_RELEASE);
  }
}

/** Reads each field once. A length beyond the slot is left for validate() to refuse. */
template <int Order>
void readSlot(const hd_slot& slot, hd_slot& copy) HD_RT {
  copy.kind = __atomic_load_n(&slot.kind, Order);
  copy.length = __atomic_load_n(&slot.length, Order);
  copy.reserved = __atomic_load_n(&slot.reserved, Order);
  copy.seq = __atomic_load_n(&slot.seq, Order);
  copy.at_tick = __atomic_load_n(&slot.at_tick, Order);
  copyFromShared<Order>(copy.payload, slot.payload, sharedWords(std::min<std::size_t>(copy.length, kPayloadBytes)));
}

}  // namespace

CommandProducer::CommandProducer(hd_region_b* b, const hd_region_a* a, std::uint32_t start_index) noexcept
    : b_(b), a_(a), tail_(start_index), head_seen_(start_index) {
  storeRelease(b_->tail, start_index);
}

ErrorCode CommandProducer::push(std::uint32_t kind, std::span<const std::byte> payload, std::uint64_t at_tick,
                                std::uint64_t& seq) HD_RT {
  if (payload.size() > kPayloadBytes) return ErrorCode::kInvalidArgument;
  if (tail_ - head_seen_ >= HD_RING_SLOTS) {
    head_seen_ = loadAcquire(a_->acks.ring_head);  // A1, pairs with R1: the slot has been copied
    if (tail_ - head_seen_ >= HD_RING_SLOTS) return ErrorCode::kWouldBlock;
  }
  seq = ++seq_;
  // Plain writes: until the tail moves, the slot is ours alone.
  hd_slot& slot = b_->ring[tail_ & kSlotMask];
  slot.kind = kind;
  slot.length = static_cast<std::uint32_t>(payload.size());
  slot.reserved = 0;
  slot.seq = seq;
  slot.at_tick = at_tick;
  if (!payload.empty()) std::memcpy(slot.payload, payload.data(), payload.size());
  storeRelease(b_->tail, ++tail_);  // R0, pairs with A0: the slot is whole
  return ErrorCode::kOk;
}

void CommandProducer::heartbeat(std::int64_t now_ns) HD_RT { storeRelaxed(b_->heartbeat_ns, now_ns); }

std::uint32_t CommandProducer::space() const HD_RT {
  const std::uint32_t fill = tail_ - loadAcquire(a_->acks.ring_head);  // A1, pairs with R1
  return fill > HD_RING_SLOTS ? 0 : HD_RING_SLOTS - fill;
}

CommandConsumer::CommandConsumer(const hd_region_b* b, hd_region_a* a, std::uint32_t start_index) noexcept
    : b_(b), a_(a), head_(start_index), tail_seen_(start_index) {
  if (a_ != nullptr) storeRelease(a_->acks.ring_head, start_index);
}

CommandConsumer::Pop CommandConsumer::pop(hd_slot& copy) HD_RT {
  if (violated_) return Pop::kViolation;
  if (head_ == tail_seen_) {
    tail_seen_ = loadAcquire(b_->tail);  // A0, pairs with R0: slots before the tail are whole
    if (head_ == tail_seen_) return Pop::kEmpty;
    if (tail_seen_ - head_ > HD_RING_SLOTS) {
      violated_ = true;
      return Pop::kViolation;
    }
  }
  readSlot<__ATOMIC_RELAXED>(b_->ring[head_ & kSlotMask], copy);
  storeRelease(a_->acks.ring_head, ++head_);  // R1, pairs with A1: the slot may be written again
  return Pop::kSlot;
}

std::uint32_t CommandConsumer::pushed() const HD_RT { return loadAcquire(b_->tail); }  // As A0, pairs with R0.

std::int64_t CommandConsumer::heartbeat() const HD_RT { return loadRelaxed(b_->heartbeat_ns); }

// The mailbox is a seqlock without fences: each word is stored with release and loaded with acquire. A reader that sees
// a word of write n + 1 (A2, pairs with R2) therefore also sees the guard that was stored before it, and its last look
// at the guard differs from the first.

ErrorCode MailboxWriter::write(std::uint32_t kind, std::span<const std::byte> payload, std::uint64_t& seq) HD_RT {
  if (payload.size() > kPayloadBytes) return ErrorCode::kInvalidArgument;
  seq = ++seq_;
  storeRelaxed(slot_->guard, guard_ + 1);    // odd: being written
  writeMailbox(*slot_, kind, payload, seq);  // R2, pairs with A2
  storeRelease(slot_->guard, guard_ += 2);   // R3, pairs with A3: it stands
  return ErrorCode::kOk;
}

MailboxReader::Read MailboxReader::read(hd_slot& copy) HD_RT {
  for (int tries = 0; tries < 2; ++tries) {
    const std::uint32_t before = loadAcquire(slot_->guard);  // A3, pairs with R3
    if (before == guard_) return Read::kSame;
    if ((before & 1u) != 0) continue;
    readSlot<__ATOMIC_ACQUIRE>(*slot_, copy);  // A2, pairs with R2
    if (loadRelaxed(slot_->guard) != before) continue;
    former_ = std::exchange(guard_, before);
    return Read::kNew;
  }
  return Read::kBusy;
}

}  // namespace hapticd
