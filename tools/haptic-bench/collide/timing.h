/** @file
 * Many queries timed one by one in the thread's own processor time, with warm or with cold caches.
 */
#pragma once

#include <functional>
#include <vector>

#include "rt/base/math.h"

namespace haptic_bench {

/** Of the times of one subject [ms]. */
struct Times {
  double mean = 0, p50 = 0, p99 = 0, p999 = 0, max = 0;
  double steady999 = 0;  ///< p99.9 over the poses of each pose's median over the passes: free of what else ran.
  std::size_t count = 0;
};

/** `passes` times the same poses. */
[[nodiscard]] Times summarise(std::vector<double> ms, std::size_t passes = 1);

/** Thread CPU time [ns], less what reading it takes is up to the caller. */
[[nodiscard]] double threadNs();
/** Of all threads: what a builder or a library starts to help it counts as well [ns]. */
[[nodiscard]] double processNs();
/** What reading it takes [ns]: the least of many. */
[[nodiscard]] double readingNs();

struct TimingOptions {
  int stride = 1;        ///< Every so many poses.
  int passes = 1;        ///< Over all of them.
  double seconds = 1e9;  ///< Of processor time, after which no further pass begins.
  bool cold = false;     ///< Walks more memory than any cache holds before each query.
};

/** Milliseconds of `query` at each pose; in the order they were asked, in whole passes. */
[[nodiscard]] std::vector<double> timeQueries(const std::vector<hapticd::Pose>& poses, const TimingOptions& options,
                                              const std::function<void(std::size_t)>& query);

}  // namespace haptic_bench
