/** @file
 * One algorithm over one trajectory on one model: the thesis's evaluation (figure 4.3).
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/metric/metrics.h"
#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/surface.h"

namespace haptic_bench {

/** What came of it. */
struct Outcome {
  std::vector<Answer> answers;        ///< Of the first round, one for each sample.
  std::vector<std::int64_t> step_ns;  ///< The same: what the first of `rounds` sums up.
  std::vector<Timing> rounds;         ///< Times of the steps; each includes one reading of the clock, about 30 ns.
  std::vector<double> init_s;         ///< Of create(), with whatever tree or volume it builds: one for each round.
  std::uint64_t bytes = 0;            ///< 0: unknown.
  bool repeats = true;                ///< Every round gave the same forces, bit for bit.
};

/**
 * Throws Failure if one of several algorithms refuses its settings or the model: else that would show only when those
 * before it have run. One alone needs no such look.
 */
void requireAlgorithms(const std::vector<std::string>& algorithms, const Model& model, const Trajectory& trajectory,
                       const Surface& surface);

/** Runs `rounds` times. Throws Failure when the algorithm refuses or answers a force that is not finite (which sample).
 */
[[nodiscard]] Outcome runTrial(const std::string& algorithm, const Model& model, const Trajectory& trajectory,
                               const Surface& surface, int rounds);

/**
 * The outcome as series, their names beginning with `name`: force MSE, proxy errors, samples above `threshold` [m],
 * energy error, hash; times, init and memory. Quantities that the trajectory has no truth for are left out.
 */
[[nodiscard]] std::vector<Series> describe(const std::string& name, const Trajectory& trajectory,
                                           const Outcome& outcome, double threshold);

}  // namespace haptic_bench
