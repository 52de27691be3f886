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

}  // namespace haptic_bench
