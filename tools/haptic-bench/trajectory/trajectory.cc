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

Trajectory pressInto(const std::vector<SurfaceSample>& out, const Surface& surface) {
  Trajectory in;
  in.proxy_known = in.force_known = true;
  in.samples.reserve(out.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const SurfaceSample& s = out[i];
    Vec3 force = s.force * s.normal;
    if (surface.friction_dynamic > 0 && out.size() > 1) {
      const Vec3 way = i == 0 ? Vec3(out[1].point - s.point) : Vec3(s.point - out[i - 1].point);
      const Vec3 slide = way - s.normal * s.normal.dot(way);
      if (slide.norm() > 0) force -= surface.friction_dynamic * s.force * slide.normalized();
    }
    const Vec3 centre = s.point + surface.radius * s.normal;
    in.samples.push_back({s.t_s, centre - force / surface.stiffness, centre, force});
  }
  if (!out.empty()) {
    in.start = out.front().point + out.front().normal * (surface.radius + out.front().force / surface.stiffness);
  }
  return in;
}

}  // namespace haptic_bench
