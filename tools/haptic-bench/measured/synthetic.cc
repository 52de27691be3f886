#include "tools/haptic-bench/measured/synthetic.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace haptic_bench {
namespace {

/** Normally distributed, the same numbers everywhere. */
class Noise {
 public:
  explicit Noise(std::uint32_t seed) : random_(seed) {}
  Vec3 vector(double deviation) {
    Vec3 v;
    for (int i = 0; i < 3; ++i) {
      const double u = (random_() + 1.0) / 4294967297.0, w = random_() / 4294967296.0;
      v[i] = deviation * std::sqrt(-2 * std::log(u)) * std::cos(2 * EIGEN_PI * w);
    }
    return v;
  }

 private:
  std::mt19937 random_;
};

/** Straight between the samples. */
SurfaceSample sampleAt(const std::vector<SurfaceSample>& out, double t) {
  const auto after =
      std::upper_bound(out.begin(), out.end(), t, [](double x, const SurfaceSample& s) { return x < s.t_s; });
  if (after == out.begin()) return out.front();
  if (after == out.end()) return out.back();
  const SurfaceSample &a = *(after - 1), &b = *after;
  const double u = (t - a.t_s) / (b.t_s - a.t_s);
  return {t, a.point + u * (b.point - a.point), (a.normal + u * (b.normal - a.normal)).normalized(),
          a.force + u * (b.force - a.force)};
}

}  // namespace

Recording record(const std::vector<SurfaceSample>& out, const Apparatus& a) {
  Recording recording;
  Noise noise(a.seed);
  const double end = a.free_s + out.back().t_s;
  // The hand turns the probe about the tip, slowly enough for the tracker.
  const auto turnAt = [&](double t) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::sin(1.7 * t), Vec3::UnitX()) *
                              Eigen::AngleAxisd(EIGEN_PI + 0.6 * std::sin(1.1 * t + 1), Vec3::UnitY()));
  };
  const auto stateAt = [&](double t) {
    SurfaceSample s = sampleAt(out, std::max(0.0, t - a.free_s));
    if (t >= a.free_s) return s;
    s.force = 0;
    s.point += (a.free_s - t) * 0.02 * s.normal;  // Coming down.
    return s;
  };
  for (std::size_t i = 0; i <= static_cast<std::size_t>(end * a.pose_hz); ++i) {
    const double t = static_cast<double>(i) / a.pose_hz;
    const SurfaceSample s = stateAt(t);
    const Vec3 tip_O = a.X_OM * Vec3(s.point + a.tip_radius * s.normal);
    const Eigen::Quaterniond q = turnAt(t);
    recording.poses.push_back(
        {t, {tip_O - q * a.tip_S + noise.vector(a.pose_noise), q}, Eigen::Quaterniond::Identity()});
  }
  for (std::size_t i = 0; i <= static_cast<std::size_t>(end * a.force_hz); ++i) {
    const double t = static_cast<double>(i) / a.force_hz;
    const SurfaceSample s = stateAt(t);
    const Vec3 felt_O = a.X_OM.q * Vec3(s.force * s.normal) - a.load.weight * Vec3::UnitZ();
    recording.forces.push_back({t, turnAt(t).conjugate() * felt_O + a.load.bias_S + noise.vector(a.force_noise)});
  }
  return recording;
}

}  // namespace haptic_bench
