#include "tools/haptic-bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/result/results.h"

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
  double probability = std::pow(0.5, static_cast<double>(n));  // of exactly k on one side
  double below = 0;
  while (k < n / 2 && 2 * (below + probability) <= 0.05) {
    below += probability;
    probability *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    ++k;
  }
  const std::size_t at = k == 0 ? 0 : k - 1;
  e.low = samples[at];
  e.high = samples[n - 1 - at];
  return e;
}

Series ratio(std::string name, const Series& a, const Series& b) {
  Series r{std::move(name), "", {}};
  for (std::size_t i = 0; i < a.rounds.size() && i < b.rounds.size(); ++i)
    r.rounds.push_back(a.rounds[i] / b.rounds[i]);
  return r;
}

void print(const Common& common, const std::string& benchmark, const std::vector<Series>& all) {
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  if (common.csv) {
    fmt::print("benchmark,quantity,unit,round,value\n");
    for (const Series& s : all) {
      for (std::size_t i = 0; i < s.rounds.size(); ++i) {
        fmt::print("{},{},{},{},{}\n", csvField(benchmark), csvField(s.name), s.unit, i + 1, s.rounds[i]);
      }
    }
    return;
  }
  std::size_t width = 0;
  for (const Series& s : all) width = std::max(width, s.name.size());
  fmt::print("\n{:<{}}  {:>10}  {:>23}  rounds\n", benchmark, width, "median", "95 % interval");
  for (const Series& s : all) {
    const Estimate e = estimate(s.rounds);
    fmt::print("{:<{}}  {:>10.4g}  {:>10.4g} .. {:>9.4g}  {} {}\n", s.name, width, e.median, e.low, e.high,
               s.rounds.size(), s.unit);
  }
}

}  // namespace haptic_bench
