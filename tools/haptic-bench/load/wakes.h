/** @file
 * Wake-ups of a real-time thread, pooled from many short slices: a tail is made of few samples, so it takes them all.
 */
#pragma once

#include <cstdint>
#include <vector>

namespace haptic_bench {

/** Lateness [ns] of every wake-up in one slice. */
using Wakes = std::vector<std::int64_t>;

/** The smallest sample of all slices together that at least `part` of them do not exceed. 0 without samples. */
[[nodiscard]] double pooledQuantile(const std::vector<Wakes>& slices, double part);

/** A number and the interval that holds it with 95 %. */
struct Interval {
  double value = 0, low = 0, high = 0;
};

/**
 * Ratio of a's pooled quantile to b's. The slices come in pairs, a's n-th beside b's; the interval is that of a
 * bootstrap over the pairs (Efron and Tibshirani, An Introduction to the Bootstrap, 13.3), because what disturbs a
 * machine comes in bursts, which make the samples of one slice depend on each other.
 */
[[nodiscard]] Interval pooledRatio(const std::vector<Wakes>& a, const std::vector<Wakes>& b, double part,
                                   std::uint32_t seed);

}  // namespace haptic_bench
