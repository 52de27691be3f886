#include "rt/ingest/ingest.h"

#include <algorithm>
#include <bit>

#include "rt/ring/shared.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kRing = 0;  // Command::channel

constexpr std::uint32_t bit(IngestReport::Kind kind) { return 1u << static_cast<std::uint32_t>(kind); }

}  // namespace

Ingest::Ingest(const IngestConfig& config) noexcept : config_(config) {}

void Ingest::step(std::int64_t now_ns, std::uint64_t tick) HD_RT {
  takeOrders(now_ns);
  for (std::uint32_t i = 0; i < kMaxSessions; ++i) {
    Slot& slot = slots_[i];
    if (!slot.used) continue;
    watchHeartbeat(slot, now_ns);
    if (!slot.lost) tellServo(i);  // Of one that is back first: of a lost session it refuses what comes next.
    slot.budget_left = config_.budget_per_session;
    slot.mailboxes_left = HD_MAILBOXES;
  }
  // Only what the servo takes in one tick may stand in its ring: a command that a flood of others has overtaken there
  // could not be put back.
  room_ = kIngestCommandsPerCycle - std::min(commands.size(), kIngestCommandsPerCycle);
  for (const std::uint32_t most : {limits::kFairShare, config_.budget_per_session}) {
    for (std::uint32_t i = 0; i < kMaxSessions; ++i) take((first_ + i) % kMaxSessions, most, tick);
  }
  passTurnOn();
  for (std::uint32_t i = 0; i < kMaxSessions; ++i) {
    tellServo(i);
    report(i, now_ns);
  }
}

/**
 * On past the first that had more than its share: each that wants more is first in turn, whatever stands empty, idle or
 * content between them. Where none had, for others than clients have left no room, past the first that had anything.
 */
void Ingest::passTurnOn() HD_RT {
  for (const std::uint32_t more : {limits::kFairShare, 0u}) {
    for (std::uint32_t i = 0; i < kMaxSessions; ++i) {
      const std::uint32_t index = (first_ + i) % kMaxSessions;
      const Slot& slot = slots_[index];
      if (!slot.used || config_.budget_per_session - slot.budget_left <= more) continue;
      first_ = (index + 1) % kMaxSessions;
      return;
    }
  }
}

void Ingest::takeOrders(std::int64_t now_ns) HD_RT {
  IngestOrder order;
  for (std::uint32_t n = 0; n < decltype(orders)::kCapacity && orders.pop(order); ++n) {
    if (order.slot >= kMaxSessions) continue;
    Slot& slot = slots_[order.slot];
    if (order.kind == IngestOrder::Kind::kDetach) {
      slot.used = false;
      received[order.slot].store(0, std::memory_order_relaxed);
      slot.reports_due = bit(IngestReport::Kind::kDetached);
      continue;
    }
    slot = Slot{};
    slot.session = order.session;
    slot.consumer = CommandConsumer(order.session.b, order.session.a, order.start_index);
    for (std::uint32_t m = 0; m < HD_MAILBOXES; ++m) slot.mailbox[m] = MailboxReader(&order.session.b->mailbox[m]);
    slot.heartbeat_seen_ns = now_ns;
    slot.used = true;
  }
}

void Ingest::watchHeartbeat(Slot& slot, std::int64_t now_ns) HD_RT {
  // The client's heartbeat only has to change; how old it is, is measured by our own clock.
  const std::int64_t heartbeat_ns = slot.consumer.heartbeat();
  if (heartbeat_ns != slot.last_heartbeat_ns) {
    slot.last_heartbeat_ns = heartbeat_ns;
    slot.heartbeat_seen_ns = now_ns;
  }
  const std::int64_t age_ns = now_ns - slot.heartbeat_seen_ns;
  storeRelaxed(slot.session.a->acks.heartbeat_age_ns, age_ns);
  const bool lost = age_ns > config_.stale_after_ns;
  if (slot.violated || lost == slot.lost) return;
  slot.lost = lost;
  slot.reports_due &= ~(bit(IngestReport::Kind::kStale) | bit(IngestReport::Kind::kAlive));
  slot.reports_due |= bit(lost ? IngestReport::Kind::kStale : IngestReport::Kind::kAlive);
}

void Ingest::take(std::uint32_t index, std::uint32_t most, std::uint64_t tick) HD_RT {
  Slot& slot = slots_[index];
  for (std::uint32_t n = 0; n < most && slot.used && !slot.violated && room_ > 0 && slot.budget_left > 0; ++n) {
    if (!takeOne(index, tick)) return;
    --slot.budget_left;
  }
}

bool Ingest::takeOne(std::uint32_t index, std::uint64_t tick) HD_RT {
  if (takeWhatWaited(index, tick)) return true;
  // In turns, so that neither a full ring nor busy mailboxes starve the other.
  Slot& slot = slots_[index];
  slot.ring_first = !slot.ring_first;
  return slot.ring_first ? takeFromRing(index, tick) || takeFromMailboxes(index, tick)
                         : takeFromMailboxes(index, tick) || takeFromRing(index, tick);
}

bool Ingest::takeFromRing(std::uint32_t index, std::uint64_t tick) HD_RT {
  Slot& slot = slots_[index];
  switch (slot.consumer.pop(copy_)) {
    case CommandConsumer::Pop::kEmpty:
      return false;
    case CommandConsumer::Pop::kViolation:
      violate(slot);
      return false;
    case CommandConsumer::Pop::kSlot:
      break;
  }
  pass(index, slot.last_seq, kRing, tick);
  storeRelaxed(slot.session.a->acks.received_seq, slot.last_seq);
  return true;
}

bool Ingest::takeFromMailboxes(std::uint32_t index, std::uint64_t tick) HD_RT {
  Slot& slot = slots_[index];
  while (slot.mailboxes_left > 0 && !slot.violated) {
    --slot.mailboxes_left;
    const std::uint32_t m = slot.mailbox_next;
    slot.mailbox_next = (m + 1) % HD_MAILBOXES;
    if ((slot.waits >> m & 1u) == 0 && takeFromMailbox(index, m, tick)) return true;
  }
  return false;
}

/**
 * A target that gets a mailbox may have been pushed by the ring before, and from then on goes by the mailbox alone. So
 * the first message of one comes after what stood in the ring when it was found.
 */
bool Ingest::takeFromMailbox(std::uint32_t index, std::uint32_t m, std::uint64_t tick) HD_RT {
  Slot& slot = slots_[index];
  switch (slot.mailbox[m].read(copy_)) {
    case MailboxReader::Read::kSame:
      return false;
    case MailboxReader::Read::kBusy:
      storeRelaxed(slot.session.a->acks.stale_mailboxes, ++slot.stale_mailboxes);
      return false;
    case MailboxReader::Read::kNew:
      break;
  }
  if ((slot.begun >> m & 1u) == 0) {
    slot.begun |= 1u << m;
    slot.behind[m] = slot.consumer.pushed();  // After read(), which has acquired what the client stored before (A3).
    if (!slot.consumer.passed(slot.behind[m])) {
      slot.mailbox[m].putBack();
      slot.waits |= 1u << m;
      return false;
    }
  }
  copy_.at_tick = 0;  // the newest value cannot wait for a later tick
  pass(index, slot.mailbox_seq[m], m + 1, tick);
  return true;
}

bool Ingest::takeWhatWaited(std::uint32_t index, std::uint64_t tick) HD_RT {
  Slot& slot = slots_[index];
  for (std::uint32_t waits = slot.waits; waits != 0; waits &= waits - 1) {
    const auto m = static_cast<std::uint32_t>(std::countr_zero(waits));
    if (!slot.consumer.passed(slot.behind[m])) continue;
    slot.waits &= ~(1u << m);
    if (takeFromMailbox(index, m, tick)) return true;
  }
  return false;
}

void Ingest::pass(std::uint32_t index, std::uint64_t& last_seq, std::uint32_t channel, std::uint64_t tick) HD_RT {
  Slot& slot = slots_[index];
  received[index].fetch_add(1, std::memory_order_relaxed);
  const std::uint64_t seq = copy_.seq;
  if (seq <= last_seq) return reject(slot, ErrorCode::kInvalidArgument, seq, channel);
  last_seq = seq;
  ErrorCode code = validate(copy_, slot.session.device_count, command_);
  if (code == ErrorCode::kOk) code = reserveTick(slot, command_.at_tick, tick);
  if (code != ErrorCode::kOk) return reject(slot, code, seq, channel);
  command_.session = index;
  command_.channel = channel;
  if (!commands.push(command_)) return reject(slot, ErrorCode::kInternal, seq, channel);  // room_ has kept it free
  --room_;
}

ErrorCode Ingest::reserveTick(Slot& slot, std::uint64_t at_tick, std::uint64_t tick) HD_RT {
  if (at_tick <= tick) return ErrorCode::kOk;
  if (at_tick - tick > config_.max_ahead_ticks) return ErrorCode::kInvalidArgument;
  for (std::uint64_t& waiting : slot.waiting) {
    if (waiting > tick) continue;  // still waits in the cycle
    waiting = at_tick;
    return ErrorCode::kOk;
  }
  return ErrorCode::kQuotaExceeded;
}

void Ingest::reject(Slot& slot, ErrorCode code, std::uint64_t seq, std::uint32_t channel) HD_RT {
  hd_acks& acks = slot.session.a->acks;
  storeRelaxed(acks.last_rejected_seq, seq);
  storeRelaxed(acks.last_rejected_code, static_cast<std::uint32_t>(code));
  storeRelaxed(acks.last_rejected_channel, channel);
  // Pairs with haptic_session_acks(): who sees the count sees these three, or newer ones.
  storeRelease(acks.rejected, ++slot.rejected);
  slot.rejection.kind = IngestReport::Kind::kRejected;
  slot.rejection.code = static_cast<std::uint32_t>(code);
  slot.rejection.channel = channel;
  slot.rejection.seq = seq;
  ++slot.unreported;
}

void Ingest::violate(Slot& slot) HD_RT {
  slot.violated = true;
  slot.lost = true;
  slot.reports_due |= bit(IngestReport::Kind::kViolation);
  storeRelaxed(slot.session.a->acks.violations, 1u);
}

void Ingest::tellServo(std::uint32_t index) HD_RT {
  Slot& slot = slots_[index];
  if (!slot.used || slot.lost == slot.told_lost) return;
  const CommandKind kind = slot.lost ? CommandKind::kLoseSession : CommandKind::kReviveSession;
  if (commands.push(makeCommand(kind, SessionRef{index, 0, slot.session.id})))
    slot.told_lost = slot.lost;  // else again in the next step
}

void Ingest::report(std::uint32_t index, std::int64_t now_ns) HD_RT {
  Slot& slot = slots_[index];
  // What does not fit stays due.
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(IngestReport::Kind::kKinds); ++k) {
    IngestReport report;
    report.kind = static_cast<IngestReport::Kind>(k);
    report.slot = index;
    if ((slot.reports_due & bit(report.kind)) != 0 && reports.push(report)) slot.reports_due &= ~bit(report.kind);
  }
  if (!slot.used || slot.unreported == 0 || now_ns < slot.next_report_ns) return;
  slot.rejection.slot = index;
  slot.rejection.suppressed = slot.unreported - 1;
  if (!reports.push(slot.rejection)) return;
  slot.unreported = 0;
  slot.next_report_ns = now_ns + kReportIntervalNs;
}

}  // namespace hapticd
