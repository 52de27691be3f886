#include "tools/haptic-bench/metric/metrics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "tools/haptic-bench/metric/quantile.h"

namespace haptic_bench {

Accuracy judge(const Trajectory& trajectory, const std::vector<Answer>& answers, double threshold) {
  Accuracy a;
  double force_sum = 0, proxy_sum = 0;
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a over words.
  Vec3 error_before = Vec3::Zero();
  std::size_t judged = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const Sample& truth = trajectory.samples[i];
    for (int axis = 0; axis < 3; ++axis) {
      // A zero's sign is no difference in force.
      hash = (hash ^ std::bit_cast<std::uint64_t>(answers[i].force[axis] + 0.0)) * 0x100000001b3u;
      hash ^= hash >> 29;
    }
    if (!truth.judged) continue;
    ++judged;
    const Vec3 error = answers[i].force - truth.force;
    force_sum += error.squaredNorm();
    if (i > 0 && trajectory.samples[i - 1].judged)
      a.energy_error += 0.5 * (error + error_before).dot(truth.hip - trajectory.samples[i - 1].hip);
    error_before = error;
    const double off = (answers[i].proxy - truth.proxy).norm();
    proxy_sum += off * off;
    a.proxy_max = std::max(a.proxy_max, off);
    if (off > threshold) ++a.above;
  }
  const auto n = static_cast<double>(std::max<std::size_t>(judged, 1));
  a.force_mse = force_sum / n;
  a.proxy_rms = std::sqrt(proxy_sum / n);
  a.hash = hash >> 16;
  if (!trajectory.force_known) a.force_mse = a.energy_error = 0;
  if (!trajectory.proxy_known) a.proxy_rms = a.proxy_max = 0, a.above = 0;
  return a;
}

Timing summarise(std::vector<std::int64_t> step_ns) {
  std::sort(step_ns.begin(), step_ns.end());
  const auto at = [&](double share) { return static_cast<double>(nearestRank(step_ns, share)); };
  Timing t;
  t.mean = static_cast<double>(std::accumulate(step_ns.begin(), step_ns.end(), std::int64_t{0})) /
           static_cast<double>(step_ns.size());
  t.median = at(0.5);
  t.p99 = at(0.99);
  t.p999 = at(0.999);
  t.max = at(1);
  return t;
}

}  // namespace haptic_bench
