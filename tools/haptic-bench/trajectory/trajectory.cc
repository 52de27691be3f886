#include "tools/haptic-bench/trajectory/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

double Trajectory::period_s() const {
  if (samples.size() < 2) return 1e-3;
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.size(); ++i) steps.push_back(samples[i].t_s - samples[i - 1].t_s);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

void countJudged(Trajectory& trajectory) {
  const std::vector<Sample>& all = trajectory.samples;
  const auto judged =
      static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [](const Sample& s) { return s.judged; }));
  if (judged == all.size()) return;
  if (judged == 0) trajectory.force_known = trajectory.proxy_known = false;
  std::string why = trajectory.unfit > 0 ? fmt::format("; at {} the ball does not fit", trajectory.unfit) : "";
  const bool session = !trajectory.own_judgement;
  if (judged + trajectory.unfit < all.size()) {
    why = (session ? ", in which the device was armed and its ramp over" : ", as its column judged says") + why;
  }
  hapticd::tellError(fmt::format("haptic-bench: {}: {} of {} samples are judged{}{}\n", trajectory.name, judged,
                                 all.size(), why, session && judged == 0 ? " (arm it once the recording runs)" : ""));
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
      force -= surface.friction_dynamic * s.force * slide.normalized();
    }
    const Vec3 centre = s.point + surface.radius * s.normal;
    in.samples.push_back({s.t_s, centre - force / surface.stiffness, centre, force});
  }
  if (!out.empty()) {
    in.start = out.front().point + out.front().normal * (surface.radius + out.front().force / surface.stiffness);
  }
  return in;
}

Trajectory atSpeed(const Trajectory& trajectory, double factor) {
  constexpr double kSame = 1e-6;  // Of a step: rounding of times.
  const std::vector<Sample>& from = trajectory.samples;
  const double mean = trajectory.duration_s() / std::max(1.0, static_cast<double>(from.size()) - 1);
  const double middle = trajectory.period_s(), first = from.front().t_s;
  const double period =
      std::abs(mean - middle) < kSame * middle ? mean : middle;  // Even steps: without their rounding.
  const double steps = std::floor(trajectory.duration_s() / (period * factor) + kSame);
  if (steps > kMaxSamples) {
    throw Failure(
        trajectory.name, fmt::format("at {} times its speed it has {:.3g} samples", factor, steps),
        fmt::format("at most {:.0e}: a greater speed, or without its gaps", static_cast<double>(kMaxSamples)));
  }
  Trajectory out = trajectory;
  out.samples.clear();
  std::size_t i = 0;
  for (int k = 0; k <= static_cast<int>(steps); ++k) {
    const double t = first + k * period * factor;
    while (i + 1 < from.size() && from[i + 1].t_s <= t + kSame * period) ++i;
    Sample s = from[i];
    if (i + 1 < from.size() && t > s.t_s + kSame * period) {
      const Sample& next = from[i + 1];
      const double u = (t - s.t_s) / (next.t_s - s.t_s);
      s.hip += u * (next.hip - s.hip);
      s.proxy += u * (next.proxy - s.proxy);
      s.force += u * (next.force - s.force);
      s.judged = s.judged && next.judged;
    }
    s.t_s = k * period;
    out.samples.push_back(s);
  }
  return out;
}

}  // namespace haptic_bench
