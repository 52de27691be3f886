/** @file
 * The times of all ticks of a stroke that is done again in each round.
 */
#pragma once

#include <algorithm>
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
  explicit TickTimes(std::string name) : name_(std::move(name)) {}

  /**
   * One more round: the stroke twice. Its summary is of the lesser time of each tick: another program takes the
   * processor for 4 ms now and then, which else decides means and tails of every round, but it does not strike a tick
   * twice.
   */
  template <class Begin, class Tick>
  void take(std::size_t count, Begin&& begin, Tick&& tick) {
    std::vector<double> first = stroke(count, begin, tick);
    const std::vector<double> second = stroke(count, begin, tick);
    add(std::move(first), second);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  /** Of each tick the median over the rounds, of their second strokes: the first has warmed the caches [ns]. */
  [[nodiscard]] std::vector<double> medians() const;
  /** Median, mean, tails and maximum of each round. */
  [[nodiscard]] std::vector<Series> series() const;

 private:
  template <class Begin, class Tick>
  std::vector<double> stroke(std::size_t count, Begin&& begin, Tick&& tick) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> ticks(count);
    const double reading = clockReading();
    begin();
    for (std::size_t i = 0; i < count; ++i) {
      const auto start = Clock::now();
      tick(i);
      ticks[i] = std::chrono::duration<double, std::nano>(Clock::now() - start).count();
    }
    for (double& t : ticks) t = std::max(t - reading, 0.0);
    return ticks;
  }
  void add(std::vector<double> first, const std::vector<double>& second);

  std::string name_;
  std::vector<TickSummary> rounds_;
  std::vector<std::vector<float>>
      kept_;  // Of the second strokes. For up to 10000 rounds of many things: half the memory.
};

}  // namespace haptic_bench
