/** @file
 * Region A: what the daemon publishes. The writer never waits; a reader on a read-only mapping sees a whole sample or
 * none, and counts what it lost.
 */
#pragma once

#include <cstdint>
#include <span>

#include "proto/shm_layout.h"
#include "rt/base/contract.h"

namespace hapticd {

/** What region A is told about the session before it is handed out. */
struct RegionIdentity {
  std::uint64_t epoch = 0;
  std::uint64_t session = 0;
  std::uint32_t device_count = 1;
  std::int64_t period_ns = 1'000'000;
};

/** Fills both headers; `ready` last. Control thread, before the client maps. */
void initialiseRegions(hd_region_a* a, hd_region_b* b, const RegionIdentity& identity) noexcept;

/** Client side: kOk, kVersionMismatch, or kBadSnapshot-like kInvalidArgument when the header is not ours. */
[[nodiscard]] bool headerMatches(const hd_shm_header& header, char region, std::uint64_t bytes) noexcept;

/** Servo side. One thread. */
class StateWriter {
 public:
  explicit StateWriter(hd_region_a* a) noexcept : a_(a) {}
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
  explicit StateReader(const hd_region_a* a) noexcept;
  /** Latest sample of a device. False when none stands yet or the writer was faster twice. */
  bool latest(std::uint32_t device, hd_sample& out) const HD_RT;
  /** Oldest unread samples, in order. Returns how many; adds what was overwritten unread to `lost`. */
  std::uint32_t drain(std::span<hd_sample> out, std::uint64_t& lost) HD_RT;

 private:
  const hd_region_a* a_;
  std::uint64_t next_ = 0;
};

}  // namespace hapticd
