/** @file
 * Ingest: takes what clients wrote, trusts none of it, and hands the servo checked commands.
 *
 * One ingest serves one device group at the servo's rate. It drains each session's ring and mailboxes within a budget,
 * copies each slot once, checks the copy, acknowledges it in region A and passes it on through a private ring.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "rt/command.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/spsc.h"

namespace hapticd {

using IngestToServo = SpscRing<Command, 256>;
using ControlToServo = SpscRing<Command, 512>;

/** A session as ingest serves it. Filled by control, used after kAttach. */
struct IngestSession {
  std::uint64_t id = 0;
  const hd_region_b* b = nullptr;
  hd_region_a* a = nullptr;
  std::uint32_t device_count = 1;
};

/** Control's orders to ingest. */
struct IngestOrder {
  enum class Kind : std::uint32_t { kAttach, kDetach } kind = Kind::kAttach;
  std::uint32_t slot = 0;
  IngestSession session;
};

/** What ingest tells control: for logs, events and the end of a session. */
struct IngestReport {
  enum class Kind : std::uint32_t { kDetached, kViolation, kRejected, kStale, kAlive } kind = Kind::kDetached;
  std::uint32_t slot = 0;
  std::uint32_t code = 0;        ///< ErrorCode of a rejection.
  std::uint32_t suppressed = 0;  ///< Reports of this kind not sent since the last one.
  std::uint64_t seq = 0;
};

struct IngestConfig {
  std::uint32_t budget_per_session = 16;      ///< Slots a session may pass per step.
  std::int64_t stale_after_ns = 200'000'000;  ///< Heartbeat older than this: the session counts as lost.
  std::uint64_t max_ahead_ticks = 40'000;     ///< at_tick further ahead is refused.
};

class Ingest {
 public:
  explicit Ingest(const IngestConfig& config) noexcept;

  /** One round. `now_ns` is the caller's clock, `tick` the servo's last. Bounded by sessions times budget. */
  void step(std::int64_t now_ns, std::uint64_t tick) HD_RT;

  SpscRing<IngestOrder, 64> orders;     ///< From control.
  SpscRing<IngestReport, 256> reports;  ///< To control.
  IngestToServo commands;               ///< To the servo; also carries kLoseSession and kReviveSession.

 private:
  struct Slot {
    bool used = false;
    bool lost = false;
    bool violated = false;
    IngestSession session;
    CommandConsumer consumer{nullptr, nullptr};
    std::array<MailboxReader, HD_MAILBOXES> mailbox;
    std::uint64_t last_seq = 0;
    std::int64_t last_heartbeat_ns = 0;  ///< As the client wrote it.
    std::int64_t heartbeat_seen_ns = 0;  ///< When it last changed, by our clock.
    std::uint32_t rejected_since_report = 0;
    Slot() noexcept;
  };

  IngestConfig config_;
  std::array<Slot, kMaxSessions> slots_;
};

/**
 * Checks a private copy of a slot: kind, length, finite, ranges. On kOk `out` is what the servo may use (kind, seq,
 * at_tick and payload set; session is the caller's to set). Pure.
 */
[[nodiscard]] ErrorCode validate(const hd_slot& copy, std::uint32_t device_count, Command& out) HD_RT;

}  // namespace hapticd
