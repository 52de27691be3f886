/** @file
 * What a run is judged by: thesis section 4.2.2, "Metric extraction".
 */
#pragma once

#include <cstdint>
#include <vector>

#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

/** What an algorithm answered to one sample. */
struct Answer {
  Vec3 force = Vec3::Zero();  ///< [N]
  Vec3 proxy = Vec3::Zero();  ///< [m]
  bool touches = false;
};

struct Accuracy {
  double force_mse = 0;     ///< Mean of |F_truth - F|^2 [N^2].
  double proxy_rms = 0;     ///< Of |proxy - truth| [m].
  double proxy_max = 0;     ///< [m]
  std::uint64_t above = 0;  ///< Samples whose proxy is further off than the threshold.
  /** Work of the force's error along the hand's path, trapezoids [J]: energy that comes from nowhere or goes there. */
  double energy_error = 0;
  std::uint64_t hash = 0;  ///< Of the bits of all forces; 48 bits, so that a double holds it.
};

/** `threshold` [m] of the position error. Truth that is unknown counts nothing. */
[[nodiscard]] Accuracy judge(const Trajectory& trajectory, const std::vector<Answer>& answers, double threshold);

/** Times of single steps [ns]. */
struct Timing {
  double mean = 0, median = 0, p99 = 0, p999 = 0, max = 0;
};

/** Percentiles by nearest rank. Needs at least one time. */
[[nodiscard]] Timing summarise(std::vector<std::int64_t> step_ns);

}  // namespace haptic_bench
