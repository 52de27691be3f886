/** @file
 * Percentiles, the same way everywhere.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace haptic_bench {

/**
 * The smallest of the samples that at least `share` of them do not exceed: nearest rank. Of 1000, the 990th for 0.99
 * and the 999th, not the greatest, for 0.999. `sorted` rises and is not empty.
 */
template <class T>
[[nodiscard]] T nearestRank(const std::vector<T>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

/** The one in the middle, or of an even number the mean of both. `samples` are not empty; their order changes. */
template <class T>
[[nodiscard]] double middleOf(std::vector<T>& samples) {
  const auto upper = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(samples.begin(), upper, samples.end());
  const auto middle = static_cast<double>(*upper);
  return samples.size() % 2 != 0 ? middle
                                 : (static_cast<double>(*std::max_element(samples.begin(), upper)) + middle) / 2;
}

}  // namespace haptic_bench
