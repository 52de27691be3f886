#include "tools/haptic-bench/cost/tick_times.h"

#include <algorithm>
#include <numeric>

#include "tools/haptic-bench/metric/quantile.h"

namespace haptic_bench {

double clockReading() {
  using Clock = std::chrono::steady_clock;
  double least = 1e9;
  for (int i = 0; i < 1000; ++i) {
    const auto start = Clock::now();
    least = std::min(least, std::chrono::duration<double, std::nano>(Clock::now() - start).count());
  }
  return least;
}

TickSummary summariseTicks(std::vector<double> ticks) {
  TickSummary summary;
  summary.mean = std::accumulate(ticks.begin(), ticks.end(), 0.0) / static_cast<double>(ticks.size());
  std::sort(ticks.begin(), ticks.end());
  summary.median = nearestRank(ticks, 0.5);
  summary.p99 = nearestRank(ticks, 0.99);
  summary.p999 = nearestRank(ticks, 0.999);
  summary.max = ticks.back();
  return summary;
}

void TickTimes::add(std::vector<double> first, const std::vector<double>& second) {
  kept_.emplace_back(second.begin(), second.end());
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = std::min(first[i], second[i]);
  rounds_.push_back(summariseTicks(std::move(first)));
}

std::vector<double> TickTimes::medians() const {
  std::vector<double> ticks(kept_.empty() ? 0 : kept_.front().size());
  std::vector<float> one(kept_.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    for (std::size_t r = 0; r < one.size(); ++r) one[r] = kept_[r][i];
    ticks[i] = middleOf(one);
  }
  return ticks;
}

std::vector<Series> TickTimes::series() const {
  std::vector<Series> all;
  const auto add = [&](const char* what, double TickSummary::*figure) {
    Series s{name_ + " " + what, "ns", {}};
    for (const TickSummary& round : rounds_) s.rounds.push_back(round.*figure);
    all.push_back(std::move(s));
  };
  add("median", &TickSummary::median);
  add("mean", &TickSummary::mean);
  add("p99", &TickSummary::p99);
  add("p99.9", &TickSummary::p999);
  add("max", &TickSummary::max);
  return all;
}

}  // namespace haptic_bench
