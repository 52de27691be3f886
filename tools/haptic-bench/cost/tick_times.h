/** @file
 * The times of all ticks of a stroke that is done again in each round.
 */
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tools/haptic-bench/bench.h"

namespace haptic_bench {

/** What reading the clock takes [ns]: the least of many. */
[[nodiscard]] double clockReading();

/** Of one round, or of the medians of all [ns]. */
struct TickSummary {
  double mean = 0, median = 0, p99 = 0, p999 = 0, max = 0;
};
[[nodiscard]] TickSummary summariseTicks(std::vector<double> ticks);

/** One thing that is timed tick by tick. */
class TickTimes {
 public:
  /** `keep`: each tick of each round, for medians(); else summaries alone. */
  TickTimes(std::string name, bool keep) : name_(std::move(name)), keep_(keep) {}

  /** One more round. */
  template <class Tick>
  void take(std::size_t count, Tick&& tick) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> ticks(count);
    const double reading = clockReading();
    for (std::size_t i = 0; i < count; ++i) {
      const auto start = Clock::now();
      tick(i);
      ticks[i] = std::chrono::duration<double, std::nano>(Clock::now() - start).count();
    }
    add(std::move(ticks), reading);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  /** Of each tick the median over the rounds [ns]. */
  [[nodiscard]] std::vector<double> medians() const;
  /** Median, mean, tails and maximum of each round. */
  [[nodiscard]] std::vector<Series> series() const;

 private:
  void add(std::vector<double> ticks, double reading);

  std::string name_;
  bool keep_;
  std::vector<TickSummary> rounds_;
  std::vector<std::vector<float>> kept_;  // For up to 10000 rounds of many things: half the memory.
};

}  // namespace haptic_bench
