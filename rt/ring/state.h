/** @file
 * Region A: what the daemon publishes. The writer never waits; a reader on a read-only mapping sees a whole sample or
 * none, and counts what it lost.
 */
#pragma once

#include <cstdint>
#include <span>

#include "proto/shm_layout.h"
#include "rt/base/contract.h"
#include "rt/base/error.h"

namespace hapticd {

/** What region A is told about the session before it is handed out. */
struct RegionIdentity {
  std::uint64_t epoch = 0;
  std::uint64_t session = 0;
  std::uint32_t device_count = 1;
  std::int64_t period_ns = 1'000'000;
};

/** Clears both regions and fills their headers, `ready` last. Control thread, before the client maps. */
void initialiseRegions(hd_region_a* a, hd_region_b* b, const RegionIdentity& identity) noexcept;

/**
 * Client side: whether this program can read a region ('A' or 'B') of which `bytes` are mapped. kVersionMismatch when
 * it is of another major or an older minor version, kInvalidArgument when it is not such a region, not ready, or too
 * short.
 */
[[nodiscard]] ErrorCode checkHeader(const hd_shm_header& header, char region, std::uint64_t bytes) noexcept;

/** True when checkHeader() finds nothing to object to. */
[[nodiscard]] inline bool headerMatches(const hd_shm_header& header, char region, std::uint64_t bytes) noexcept {
  return checkHeader(header, region, bytes) == ErrorCode::kOk;
}

/** Servo side. One thread. */
class StateWriter {
 public:
  explicit StateWriter(hd_region_a* a = nullptr) noexcept : a_(a) {}
  /** Publishes a sample to the history and as the latest of its device. `sample.guard` is ignored. */
  void publish(const hd_sample& sample) HD_RT;
  [[nodiscard]] hd_region_a* region() const HD_RT { return a_; }

 private:
  hd_region_a* a_;
  std::uint64_t tail_ = 0;
  std::uint64_t latest_count_[HD_MAX_DEVICES] = {};
};

/** Client side. One thread per reader. */
class StateReader {
 public:
  /** Starts with the next sample that the servo publishes. */
  explicit StateReader(const hd_region_a* a) noexcept;
  /** Latest sample of a device: the one before where the writer is stopped in the middle of the latest. False when
   * none stands yet, or this thread itself was stopped meanwhile until the whole history was written over. */
  bool latest(std::uint32_t device, hd_sample& out) const HD_RT;
  /** Oldest unread samples, in order. Returns how many; adds what was overwritten unread to `lost`. */
  std::uint32_t drain(std::span<hd_sample> out, std::uint64_t& lost) HD_RT;

 private:
  bool newestInHistory(std::uint32_t device, hd_sample& out) const HD_RT;

  const hd_region_a* a_;
  std::uint64_t next_ = 0;
};

}  // namespace hapticd
