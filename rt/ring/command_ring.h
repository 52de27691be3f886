/** @file
 * The command ring and the mailboxes of region B: the client writes, the daemon reads and trusts nothing.
 *
 * Neither side reads its own index back from shared memory, and each caches the other's and reads it only when it must.
 * The consumer copies a slot once to private memory; whoever uses it checks the copy (rt/ingest/validate.h). A fill
 * above the capacity is a protocol violation. Indices run freely and wrap at 2^32, which the capacity divides, so that
 * tail - head is the fill even across the wrap.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/shm_layout.h"
#include "rt/base/contract.h"
#include "rt/base/error.h"

namespace hapticd {

/** Client side. One thread. */
class CommandProducer {
 public:
  /** Both regions mapped; the ring is new (a session is never re-joined). `start_index` is for tests of the wrap. */
  CommandProducer(hd_region_b* b, const hd_region_a* a, std::uint32_t start_index = 0) noexcept;

  /** Writes one slot; `seq` receives its number. kWouldBlock when full, kInvalidArgument when too long. */
  ErrorCode push(std::uint32_t kind, std::span<const std::byte> payload, std::uint64_t at_tick,
                 std::uint64_t& seq) HD_RT;
  /** Tells the daemon that the client lives; at least every 100 ms. Any one thread, not only the pushing one. */
  void heartbeat(std::int64_t now_ns) HD_RT;
  /** Slots that can be pushed now. */
  [[nodiscard]] std::uint32_t space() const HD_RT;

 private:
  hd_region_b* b_;
  const hd_region_a* a_;
  std::uint32_t tail_;
  std::uint32_t head_seen_;
  std::uint64_t seq_ = 0;
};

/** Daemon side. Ingest thread only. */
class CommandConsumer {
 public:
  enum class Pop : std::uint8_t { kEmpty, kSlot, kViolation };

  /** Publishes `start_index` as the head. Null regions make a consumer that must not be used. */
  CommandConsumer(const hd_region_b* b, hd_region_a* a, std::uint32_t start_index = 0) noexcept;

  /**
   * Copies the next slot once into `copy`; payload beyond its length, and the guard, keep what was there before. After
   * kViolation nothing more comes.
   */
  Pop pop(hd_slot& copy) HD_RT;
  /** Index behind what the client has pushed by now, as it claims. */
  [[nodiscard]] std::uint32_t pushed() const HD_RT;
  /** Whether all slots before that index have come. */
  [[nodiscard]] bool passed(std::uint32_t index) const HD_RT { return static_cast<std::int32_t>(head_ - index) >= 0; }
  /** The client's clock when it was last alive, as it claims. */
  [[nodiscard]] std::int64_t heartbeat() const HD_RT;

 private:
  const hd_region_b* b_;
  hd_region_a* a_;
  std::uint32_t head_;
  std::uint32_t tail_seen_;
  bool violated_ = false;
};

/** Client side of one latest-value mailbox. One thread per mailbox; a mailbox is never re-joined. */
class MailboxWriter {
 public:
  explicit MailboxWriter(hd_slot* slot) noexcept : slot_(slot) {}
  /** Replaces what stands there, read or not. kInvalidArgument when too long. Takes effect at once. */
  ErrorCode write(std::uint32_t kind, std::span<const std::byte> payload, std::uint64_t& seq) HD_RT;

 private:
  hd_slot* slot_;
  std::uint32_t guard_ = 0;
  std::uint64_t seq_ = 0;
};

/** Daemon side of one mailbox. */
class MailboxReader {
 public:
  enum class Read : std::uint8_t { kSame, kNew, kBusy };
  MailboxReader() noexcept = default;
  explicit MailboxReader(const hd_slot* slot) noexcept : slot_(slot) {}
  /** At most two tries; kBusy: the writer was in the way both times, `copy` is then worthless. */
  Read read(hd_slot& copy) HD_RT;
  /** What read() has found last counts as not read: the next one finds it, or what has replaced it. */
  void putBack() HD_RT { guard_ = former_; }

 private:
  const hd_slot* slot_ = nullptr;
  std::uint32_t guard_ = 0, former_ = 0;
};

}  // namespace hapticd
