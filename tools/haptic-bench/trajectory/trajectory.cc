#include "tools/haptic-bench/trajectory/trajectory.h"

#include <algorithm>

namespace haptic_bench {

double Trajectory::period_s() const {
  if (samples.size() < 2) return 1e-3;
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) steps.push_back(samples[i].t_s - samples[i - 1].t_s);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

Trajectory pressInto(const std::vector<SurfaceSample>& out, double stiffness) {
  Trajectory in;
  in.proxy_known = in.force_known = true;
  in.samples.reserve(out.size());
  for (const SurfaceSample& s : out) {
    in.samples.push_back({s.t_s, s.point - s.normal * (s.force / stiffness), s.point, s.normal * s.force});
  }
  if (!out.empty()) in.start = out.front().point + out.front().normal * (out.front().force / stiffness);
  return in;
}

}  // namespace haptic_bench
