#include "tools/haptic-bench/load/wakes.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace haptic_bench {
namespace {

constexpr int kResamples = 1000;

/** Of the slices named by `chosen`, which may name one several times. */
double quantileOf(const std::vector<Wakes>& slices, const std::vector<std::size_t>& chosen, double part, Wakes& pool) {
  pool.clear();
  for (const std::size_t i : chosen) pool.insert(pool.end(), slices[i].begin(), slices[i].end());
  if (pool.empty()) return 0;
  const double rank = std::ceil(part * static_cast<double>(pool.size()));
  const auto at = pool.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(pool.begin(), at, pool.end());
  return static_cast<double>(*at);
}

std::vector<std::size_t> all(std::size_t count) {
  std::vector<std::size_t> chosen(count);
  for (std::size_t i = 0; i < count; ++i) chosen[i] = i;
  return chosen;
}

}  // namespace

double pooledQuantile(const std::vector<Wakes>& slices, double part) {
  Wakes pool;
  return quantileOf(slices, all(slices.size()), part, pool);
}

Interval pooledRatio(const std::vector<Wakes>& a, const std::vector<Wakes>& b, double part, std::uint32_t seed) {
  const std::size_t pairs = std::min(a.size(), b.size());
  std::vector<std::size_t> chosen = all(pairs);
  Wakes pool;
  const auto ratio = [&] { return quantileOf(a, chosen, part, pool) / quantileOf(b, chosen, part, pool); };
  Interval out;
  out.value = ratio();
  std::mt19937 random(seed);
  std::vector<double> resampled(kResamples);
  for (double& r : resampled) {
    for (std::size_t& i : chosen) i = random() % pairs;
    r = ratio();
  }
  std::sort(resampled.begin(), resampled.end());
  out.low = resampled[kResamples * 25 / 1000];
  out.high = resampled[kResamples * 975 / 1000 - 1];
  return out;
}

}  // namespace haptic_bench
