/** @file
 * Fixed-size histogram of durations, always on: one writer, any number of readers, a few nanoseconds a sample.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/**
 * Log-linear buckets: kSubBuckets per power of two, so that a percentile is known to 1 part in kSubBuckets from 1 ns to
 * 2^kPowers ns; longer values land in the last bucket, the maximum stays exact.
 */
class Histogram {
 public:
  static constexpr std::uint32_t kSubBuckets = 32;
  static constexpr std::uint32_t kPowers = 32;
  static constexpr std::uint32_t kBuckets = kSubBuckets * (kPowers - 4);  ///< Powers 0 to 4 share the first 32.

  /** Summary of what was recorded since the last reset. Percentiles are upper bounds of their bucket [ns]. */
  struct Summary {
    std::uint64_t count, p50_ns, p99_ns, p999_ns, p9999_ns, max_ns;
  };

  /** The one writer. Negative durations count as zero. */
  void record(std::int64_t duration_ns) HD_RT;
  /** Any thread. Not a snapshot: samples recorded meanwhile may be in or out. */
  [[nodiscard]] Summary summary() const noexcept;
  /** Any thread asks; the writer clears at its next sample. */
  void requestReset() noexcept { reset_.store(true, std::memory_order_release); }

 private:
  static std::uint32_t bucketOf(std::uint64_t ns) HD_RT;
  static std::uint64_t upperEdge(std::uint32_t bucket) noexcept;

  std::array<std::atomic<std::uint64_t>, kBuckets> bucket_{};
  std::atomic<std::uint64_t> max_{0};
  std::atomic<bool> reset_{false};
};

}  // namespace hapticd
