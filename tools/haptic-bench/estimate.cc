#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/bench.h"

namespace haptic_bench {

Estimate estimate(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const std::size_t n = samples.size();
  Estimate e;
  e.median = n % 2 == 1 ? samples[n / 2] : (samples[n / 2 - 1] + samples[n / 2]) / 2;
  // The interval from the k-th smallest to the k-th largest misses the median if fewer than k samples fall on one side:
  // 2 P(Binomial(n, 1/2) < k). The largest such k that misses in at most 5 %.
  std::size_t k = 0;
  double logarithm = static_cast<double>(n) * std::log(0.5);  // of the probability of exactly k on one side
  double below = 0;
  while (k < n / 2 && 2 * (below + std::exp(logarithm)) <= 0.05) {
    below += std::exp(logarithm);
    logarithm += std::log(static_cast<double>(n - k) / static_cast<double>(k + 1));
    ++k;
  }
  const std::size_t at = k == 0 ? 0 : k - 1;
  e.low = samples[at];
  e.high = samples[n - 1 - at];
  return e;
}

}  // namespace haptic_bench
