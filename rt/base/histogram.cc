#include "rt/base/histogram.h"

#include <algorithm>
#include <bit>

namespace hapticd {
namespace {

constexpr std::uint32_t kSubBits = 5;
static_assert(1u << kSubBits == Histogram::kSubBuckets);

}  // namespace

// Values below kSubBuckets have a bucket each; above, the kSubBits bits that follow the leading one choose among the
// kSubBuckets buckets of that power of two.
std::uint32_t Histogram::bucketOf(std::uint64_t ns) HD_RT {
  if (ns < kSubBuckets) return static_cast<std::uint32_t>(ns);
  const std::uint32_t power = 63u - static_cast<std::uint32_t>(std::countl_zero(ns));
  if (power >= kPowers) return kBuckets - 1;
  const auto sub = static_cast<std::uint32_t>(ns >> (power - kSubBits)) & (kSubBuckets - 1);
  return (power - kSubBits + 1) * kSubBuckets + sub;
}

std::uint64_t Histogram::upperEdge(std::uint32_t bucket) noexcept {
  if (bucket < kSubBuckets) return bucket;
  const std::uint32_t shift = bucket / kSubBuckets - 1;
  const std::uint64_t lower = static_cast<std::uint64_t>(kSubBuckets + bucket % kSubBuckets) << shift;
  return lower + (std::uint64_t{1} << shift) - 1;
}

void Histogram::record(std::int64_t duration_ns) HD_RT {
  if (reset_.load(std::memory_order_relaxed) && reset_.exchange(false, std::memory_order_acq_rel)) {
    for (auto& bucket : bucket_) bucket.store(0, std::memory_order_relaxed);
    max_.store(0, std::memory_order_relaxed);
  }
  const auto ns = static_cast<std::uint64_t>(std::max<std::int64_t>(duration_ns, 0));
  // One writer: load and store are enough, and cheaper than a locked increment.
  auto& bucket = bucket_[bucketOf(ns)];
  bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  if (ns > max_.load(std::memory_order_relaxed)) max_.store(ns, std::memory_order_relaxed);
}

Histogram::Summary Histogram::summary() const noexcept {
  Summary out{};
  if (reset_.load(std::memory_order_relaxed)) return out;  // asked for, and nothing recorded since
  std::array<std::uint64_t, kBuckets> copy;
  for (std::uint32_t i = 0; i < kBuckets; ++i) {
    copy[i] = bucket_[i].load(std::memory_order_relaxed);
    out.count += copy[i];
  }
  out.max_ns = max_.load(std::memory_order_relaxed);
  // Rank of the q-quantile: the smallest sample that at least q of all do not exceed.
  const auto rank = [&](std::uint64_t per_10000) { return (out.count * per_10000 + 9999) / 10000; };
  const std::array<std::uint64_t, 4> ranks{rank(5000), rank(9900), rank(9990), rank(9999)};
  const std::array<std::uint64_t*, 4> results{&out.p50_ns, &out.p99_ns, &out.p999_ns, &out.p9999_ns};
  std::uint64_t seen = 0;
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < kBuckets && next < ranks.size() && out.count != 0; ++i) {
    seen += copy[i];
    while (next < ranks.size() && seen >= ranks[next]) {
      // The last bucket has no upper edge; no percentile exceeds the maximum.
      *results[next++] = i == kBuckets - 1 ? out.max_ns : std::min(upperEdge(i), out.max_ns);
    }
  }
  return out;
}

}  // namespace hapticd
