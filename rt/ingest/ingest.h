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
#include "rt/ingest/limits.h"
#include "rt/ingest/validate.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/spsc.h"

namespace hapticd {

using IngestToServo = SpscRing<Command, 256>;
using ControlToServo = SpscRing<Command, 512>;

/** A session as ingest serves it. Filled by control, used after kAttach until kDetached is reported. */
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
  std::uint32_t start_index = 0;  ///< Of the command ring; for tests of the wrap.
};

/** What ingest tells control: for logs, events and the end of a session. */
struct IngestReport {
  enum class Kind : std::uint32_t {
    kDetached,   ///< The mappings are no longer used. What was taken from them is in `commands`.
    kViolation,  ///< The client broke the ring; nothing more is taken from it. End the session.
    kRejected,   ///< A message was refused; at most one report per kReportIntervalNs and session.
    kStale,      ///< The heartbeat stopped; kLoseSession was sent.
    kAlive,      ///< It is back; kReviveSession was sent.
    kKinds
  } kind = Kind::kDetached;
  std::uint32_t slot = 0;
  std::uint32_t code = 0;        ///< ErrorCode of a rejection.
  std::uint32_t suppressed = 0;  ///< Rejections not reported since the last report.
  std::uint32_t channel = 0;     ///< Where the rejected message came from: 0 the ring, k + 1 mailbox k.
  std::uint64_t seq = 0;
};

struct IngestConfig {
  std::uint32_t budget_per_session = 16;      ///< Slots a session may pass per step.
  std::int64_t stale_after_ns = 200'000'000;  ///< Heartbeat older than this: the session counts as lost.
  std::uint64_t max_ahead_ticks = 40'000;     ///< at_tick further ahead is refused.
};

/** step() belongs to the ingest thread (servo-safe); the rings to their two ends. */
class Ingest {
 public:
  static constexpr std::int64_t kReportIntervalNs = 1'000'000'000;

  explicit Ingest(const IngestConfig& config) noexcept;

  /**
   * One round; `now_ns` is the caller's clock, `tick` the servo's last. Takes no more than the servo takes in its next
   * tick, and each session at least limits::kFairShare of it if it wants them, so that a flood delays only its sender.
   * What finds no room stays in the client's ring. Bounded by sessions times (budget + twice the mailboxes).
   */
  void step(std::int64_t now_ns, std::uint64_t tick) HD_RT;

  SpscRing<IngestOrder, 64> orders;     ///< From control.
  SpscRing<IngestReport, 256> reports;  ///< To control.
  IngestToServo commands;               ///< To the servo; also carries kLoseSession and kReviveSession.
  /** Messages taken from each slot's session, by ring and mailboxes, those refused too; 0 once it is detached. */
  std::array<std::atomic<std::uint64_t>, kMaxSessions> received{};

 private:
  /** One session. Acknowledgements go to `session.a`, whose ingest fields this thread alone writes. */
  struct Slot {
    bool used = false;
    bool violated = false;
    bool lost = false;              ///< By the heartbeat or a violation.
    bool told_lost = false;         ///< What the servo was last told.
    bool ring_first = false;        ///< Whose turn it was, the ring's or the mailboxes'.
    std::uint32_t reports_due = 0;  ///< One bit per IngestReport::Kind.
    IngestSession session;
    CommandConsumer consumer{nullptr, nullptr};
    std::array<MailboxReader, HD_MAILBOXES> mailbox;
    std::array<std::uint64_t, HD_MAILBOXES> mailbox_seq{};
    std::uint32_t begun = 0, waits = 0;  ///< One bit per mailbox: a message was found; the first has still to come ...
    std::array<std::uint32_t, HD_MAILBOXES> behind{};  ///< ... after the ring's slots before that index.
    std::uint32_t mailbox_next = 0;
    std::uint32_t mailboxes_left = 0;  ///< To look at in this step.
    std::uint32_t budget_left = 0;     ///< Slots to take in this step.
    std::uint64_t last_seq = 0;
    std::array<std::uint64_t, limits::kWaitingPerSession> waiting{};  ///< Ticks of commands sent ahead.
    std::int64_t last_heartbeat_ns = 0;                               ///< As the client wrote it.
    std::int64_t heartbeat_seen_ns = 0;                               ///< When it last changed, by our clock.
    std::uint64_t rejected = 0;
    std::uint32_t stale_mailboxes = 0;
    std::uint32_t unreported = 0;  ///< Rejections since the last report.
    std::int64_t next_report_ns = 0;
    IngestReport rejection;
  };

  void passTurnOn() HD_RT;
  void takeOrders(std::int64_t now_ns) HD_RT;
  void watchHeartbeat(Slot& slot, std::int64_t now_ns) HD_RT;
  void take(std::uint32_t index, std::uint32_t most, std::uint64_t tick) HD_RT;
  bool takeOne(std::uint32_t index, std::uint64_t tick) HD_RT;
  bool takeFromRing(std::uint32_t index, std::uint64_t tick) HD_RT;
  bool takeFromMailboxes(std::uint32_t index, std::uint64_t tick) HD_RT;
  bool takeFromMailbox(std::uint32_t index, std::uint32_t m, std::uint64_t tick) HD_RT;
  bool takeWhatWaited(std::uint32_t index, std::uint64_t tick) HD_RT;
  void pass(std::uint32_t index, std::uint64_t& last_seq, std::uint32_t channel, std::uint64_t tick) HD_RT;
  ErrorCode reserveTick(Slot& slot, std::uint64_t at_tick, std::uint64_t tick) HD_RT;
  static void reject(Slot& slot, ErrorCode code, std::uint64_t seq, std::uint32_t channel) HD_RT;
  void tellServo(std::uint32_t index) HD_RT;
  void report(std::uint32_t index, std::int64_t now_ns) HD_RT;
  static void violate(Slot& slot) HD_RT;

  IngestConfig config_;
  std::array<Slot, kMaxSessions> slots_;
  std::uint32_t first_ = 0;  ///< Session that is served first; moves on past who had more than its share.
  std::uint32_t room_ = 0;   ///< Commands the servo will still take.
  hd_slot copy_{};           ///< The one private copy.
  Command command_;
};

}  // namespace hapticd
