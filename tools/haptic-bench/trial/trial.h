/** @file
 * One algorithm over one trajectory on one model: the thesis's evaluation (figure 4.3).
 */
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/metric/metrics.h"
#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/trial/surface.h"

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

/** Why it refuses its settings or the model; empty if it does not. */
[[nodiscard]] std::string refusal(const std::string& algorithm, const Model& model, const Trajectory& trajectory,
                                  const Surface& surface);

/** One algorithm, a round at a time. Holds on to model and trajectory. */
class Trial {
 public:
  Trial(std::string algorithm, const Model& model, const Trajectory& trajectory, const Surface& surface);
  /** From loading on. Throws Failure when the algorithm refuses or answers a force that is not finite (which sample).
   */
  void runRound();

  [[nodiscard]] const std::string& algorithm() const { return algorithm_; }
  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] const Outcome& outcome() const { return outcome_; }

 private:
  std::string algorithm_;
  const Model& model_;
  const Trajectory& trajectory_;
  const Surface surface_;
  Outcome outcome_;
};

/**
 * Each of them so many rounds, in turn: what keeps the machine busy for a while falls on one round of many, and not on
 * all of one algorithm, so that rounds tell how far times differ by chance. Throws as runRound().
 */
void runRounds(std::deque<Trial>& trials, int rounds);

/** Says on the standard error whose rounds differed in their forces, if nobody has felt any, and if forces seem to be
 * in another unit. */
void tellDoubts(const std::deque<Trial>& trials);

/** One alone. */
[[nodiscard]] Outcome runTrial(const std::string& algorithm, const Model& model, const Trajectory& trajectory,
                               const Surface& surface, int rounds);

/**
 * The outcome as series, their names beginning with `name`: force MSE, proxy errors, samples above `threshold` [m],
 * energy error, hash; times, init and memory. Quantities that the trajectory has no truth for are left out.
 */
[[nodiscard]] std::vector<Series> describe(const std::string& name, const Trajectory& trajectory,
                                           const Outcome& outcome, double threshold);

}  // namespace haptic_bench
