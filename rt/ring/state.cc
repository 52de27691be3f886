#include "rt/ring/state.h"

#include <cstring>

#include "rt/ring/shared.h"

namespace hapticd {
namespace {

constexpr std::size_t kSampleWords = sizeof(hd_sample) / 8 - 1;  // without the guard
constexpr std::uint64_t kHistoryMask = HD_HISTORY_SLOTS - 1;
static_assert((HD_HISTORY_SLOTS & kHistoryMask) == 0);
/** Looks before latest() turns to the history: more than it takes to write, unless the writer is stopped meanwhile. */
constexpr int kLooks = 64;
static_assert(offsetof(hd_sample, guard) == 0 && offsetof(hd_sample, tick) == 8 && sizeof(hd_sample) % 8 == 0);

// The seqlock has no fences: each word is stored with release and loaded with acquire. A reader that sees a word of
// write n + 1 (A1, pairs with R1) therefore also sees the guard that was stored before it, and its last look at the
// guard differs from the first.

void writeSample(hd_sample& slot, const hd_sample& sample, std::uint64_t n) HD_RT {
  storeRelease(slot.guard, 2 * n + 1);  // R5, pairs with A0: what was published before stands in the history
  copyToShared<__ATOMIC_RELEASE>(&slot.tick, &sample.tick, kSampleWords);  // R1, pairs with A1
  storeRelease(slot.guard, 2 * n + 2);                                     // R0, pairs with A0: the sample stands
}

/** False when the writer was there meanwhile; `guard` is what the slot held at the start. */
bool readSample(const hd_sample& slot, hd_sample& out, std::uint64_t guard) HD_RT {
  copyFromShared<__ATOMIC_ACQUIRE>(&out.tick, &slot.tick, kSampleWords);  // A1, pairs with R1
  out.guard = guard;
  return loadRelaxed(slot.guard) == guard;
}

void fillHeader(hd_shm_header& header, char region, std::uint64_t bytes, const RegionIdentity& identity) noexcept {
  header.magic = HD_SHM_MAGIC;
  header.major = HD_SHM_MAJOR;
  header.minor = HD_SHM_MINOR;
  header.header_bytes = sizeof(hd_shm_header);
  header.region_bytes = bytes;
  header.daemon_epoch = identity.epoch;
  header.session_id = identity.session;
  header.slot_bytes = HD_SLOT_BYTES;
  header.ring_slots = HD_RING_SLOTS;
  header.mailboxes = HD_MAILBOXES;
  header.history_slots = HD_HISTORY_SLOTS;
  header.sample_bytes = sizeof(hd_sample);
  header.device_count = identity.device_count;
  header.period_ns = identity.period_ns;
  header.region = static_cast<std::uint32_t>(region);  // NOLINT(bugprone-signed-char-misuse)
}

}  // namespace

void initialiseRegions(hd_region_a* a, hd_region_b* b, const RegionIdentity& identity) noexcept {
  std::memset(static_cast<void*>(a), 0, sizeof *a);
  std::memset(static_cast<void*>(b), 0, sizeof *b);
  fillHeader(a->header, 'A', sizeof *a, identity);
  fillHeader(b->header, 'B', sizeof *b, identity);
  storeRelease(a->header.ready, 1u);  // R4, pairs with A4
  storeRelease(b->header.ready, 1u);
}

ErrorCode checkHeader(const hd_shm_header& header, char region, std::uint64_t bytes) noexcept {
  const std::uint64_t wanted = region == 'A' ? sizeof(hd_region_a) : sizeof(hd_region_b);
  if (bytes < wanted || loadAcquire(header.ready) != 1) return ErrorCode::kInvalidArgument;  // A4, pairs with R4
  if (header.magic != HD_SHM_MAGIC) return ErrorCode::kInvalidArgument;
  if (header.major != HD_SHM_MAJOR || header.minor < HD_SHM_MINOR) return ErrorCode::kVersionMismatch;
  const bool shape = header.header_bytes == sizeof(hd_shm_header) && header.slot_bytes == HD_SLOT_BYTES &&
                     header.ring_slots == HD_RING_SLOTS && header.mailboxes == HD_MAILBOXES &&
                     header.history_slots == HD_HISTORY_SLOTS && header.sample_bytes == sizeof(hd_sample);
  if (!shape || header.region_bytes < wanted || header.region_bytes > bytes) return ErrorCode::kInvalidArgument;
  if (header.region != static_cast<std::uint32_t>(region)) return ErrorCode::kInvalidArgument;
  if (header.device_count < 1 || header.device_count > HD_MAX_DEVICES || header.period_ns <= 0) {
    return ErrorCode::kInvalidArgument;
  }
  return ErrorCode::kOk;
}

void StateWriter::publish(const hd_sample& sample) HD_RT {
  if (sample.device < HD_MAX_DEVICES) writeSample(a_->latest[sample.device], sample, latest_count_[sample.device]++);
  writeSample(a_->history[tail_ & kHistoryMask], sample, tail_);
  storeRelease(a_->history_tail, ++tail_);  // R2, pairs with A2: the sample stands in the history
}

StateReader::StateReader(const hd_region_a* a) noexcept : a_(a), next_(loadAcquire(a->history_tail)) {}

bool StateReader::latest(std::uint32_t device, hd_sample& out) const HD_RT {
  if (device >= HD_MAX_DEVICES) return false;
  const hd_sample& slot = a_->latest[device];
  for (int look = 0; look < kLooks; ++look) {
    const std::uint64_t guard = loadAcquire(slot.guard);  // A0, pairs with R0
    if (guard == 0) return false;
    if ((guard & 1u) == 0 && readSample(slot, out, guard)) return true;
  }
  return newestInHistory(device, out);
}

bool StateReader::newestInHistory(std::uint32_t device, hd_sample& out) const HD_RT {
  std::uint64_t n = loadAcquire(a_->history_tail);  // A2, pairs with R2
  // A tick publishes each device once: the newest of each is among as many as there are devices.
  for (std::uint32_t back = 0; back < HD_MAX_DEVICES && n != 0; ++back) {
    const hd_sample& slot = a_->history[--n & kHistoryMask];
    const std::uint64_t expected = 2 * n + 2;
    if (loadAcquire(slot.guard) != expected || !readSample(slot, out, expected)) return false;  // lapped meanwhile
    if (out.device == device) return true;
  }
  return false;
}

std::uint32_t StateReader::drain(std::span<hd_sample> out, std::uint64_t& lost) HD_RT {
  std::uint32_t got = 0;
  std::uint64_t tail = loadAcquire(a_->history_tail);  // A2, pairs with R2
  // Each turn delivers a sample or finds one overwritten. Being lapped again and again while copying takes a writer
  // some hundred times faster than any servo; the second bound ends even that.
  for (std::size_t turn = 0; turn < out.size() + HD_HISTORY_SLOTS && got < out.size() && next_ != tail; ++turn) {
    if (tail - next_ > HD_HISTORY_SLOTS) {
      lost += tail - HD_HISTORY_SLOTS - next_;
      next_ = tail - HD_HISTORY_SLOTS;
    }
    const hd_sample& slot = a_->history[next_ & kHistoryMask];
    const std::uint64_t expected = 2 * next_ + 2;
    if (loadAcquire(slot.guard) == expected && readSample(slot, out[got], expected)) {  // A0, pairs with R0
      ++got;
    } else {
      ++lost;  // the writer has taken the slot for a newer sample
      tail = loadAcquire(a_->history_tail);
    }
    ++next_;
  }
  return got;
}

}  // namespace hapticd
