#include "tools/haptic-bench/trajectory/generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

constexpr double kPi = EIGEN_PI;

/** Samples at the middles of equal steps, or of what is shorter than one at its end: f(t) gives point and normal. */
template <class F>
std::vector<SurfaceSample> sampled(double seconds, const Pace& pace, F f) {
  std::vector<SurfaceSample> out;
  const std::size_t n = samplesIn(seconds, pace);
  out.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    SurfaceSample s = f(std::min((static_cast<double>(i) + 0.5) / pace.rate_hz, seconds));
    s.t_s = static_cast<double>(i) / pace.rate_hz;
    out.push_back(s);
  }
  return out;
}

/** Three sines of 8 to 12 Hz with random phases, of root mean square 1. */
class Shake {
 public:
  explicit Shake(std::mt19937& random) {
    // Not std::uniform_real_distribution: its numbers are the library's own.
    const auto uniform = [&random] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
    for (int i = 0; i < 3; ++i)
      parts_[static_cast<std::size_t>(i)] = {8 + (i + uniform()) * 4 / 3, 2 * kPi * uniform()};
  }
  [[nodiscard]] double at(double t) const {
    double sum = 0;
    for (const auto& [hz, phase] : parts_) sum += std::sin(2 * kPi * hz * t + phase);
    return sum * std::sqrt(2.0 / 3.0);
  }

 private:
  struct Part {
    double hz = 0, phase = 0;
  };
  std::array<Part, 3> parts_{};
};

}  // namespace

std::size_t samplesIn(double seconds, const Pace& pace) {
  constexpr double kRounding = 1e-12;  // 1.001 s at 1000 Hz are 1001 samples, not 1000.99999.
  const double n = std::floor(seconds * pace.rate_hz * (1 + kRounding));
  if (n > kMaxSamples) {
    throw Failure("trajectory", fmt::format("{:g} s at {:g} Hz are {:.3g} samples", seconds, pace.rate_hz, n),
                  fmt::format("at most {:g}: fewer seconds, a lower rate or more speed", kMaxSamples));
  }
  return static_cast<std::size_t>(std::max(1.0, n));
}

std::vector<SurfaceSample> spiral(const Model& sphere, const Pace& pace, double turns) {
  return sampled(pace.seconds, pace, [&](double t) {
    const double polar = kPi * t / pace.seconds, azimuth = 2 * kPi * turns * t / pace.seconds;
    const Vec3 n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
    return SurfaceSample{0, sphere.radius * n, n, pace.force};
  });
}

std::vector<SurfaceSample> lissajous(const Model& plane, const Pace& pace) {
  return sampled(pace.seconds, pace, [&](double t) {
    const double phase = 2 * kPi * t / pace.seconds, reach = plane.half / 2;
    return SurfaceSample{0, Vec3(reach * std::sin(3 * phase), reach * std::sin(2 * phase), 0), Vec3::UnitZ(),
                         pace.force};
  });
}

std::vector<SurfaceSample> profile(const Model& ridge, const Pace& pace, double length, double speed, double y) {
  const double foot = ridge.height / std::tan(ridge.angle), flank = ridge.height / std::sin(ridge.angle);
  const double flat = length / 2 - foot;
  if (flat < 0 || length / 2 > ridge.half || std::abs(y) > ridge.half) {
    throw Failure("profile, length", "the way begins on the ridge or off the plane", "longer than the ridge's foot");
  }
  const double c = std::cos(ridge.angle), s = std::sin(ridge.angle);
  return sampled((2 * flat + 2 * flank) / speed, pace, [&](double t) {
    double way = t * speed;
    const auto at = [&](double x, double z, double nx, double nz) {
      return SurfaceSample{0, Vec3(x, y, z), Vec3(nx, 0, nz), pace.force};
    };
    if (way < flat) return at(way - length / 2, 0, 0, 1);
    if ((way -= flat) < flank) return at(-foot + way * c, way * s, -s, c);
    if ((way -= flank) < flank) return at(way * c, ridge.height - way * s, s, c);
    return at(foot + way - flank, 0, 0, 1);
  });
}

std::vector<SurfaceSample> swing(const Model& bowl, const Pace& pace, double speed) {
  const double reach = 0.8 * bowl.half / bowl.radius;  // Of the angle from the bottom.
  return sampled(pace.seconds, pace, [&](double t) {
    const double angle = reach * std::sin(std::min(t, 0.9 * pace.seconds) * speed / (bowl.radius * reach));
    const Vec3 along = Vec3(0.8, 0.6, 0);
    const Vec3 n = -std::sin(angle) * along + std::cos(angle) * Vec3::UnitZ();
    return SurfaceSample{0, Vec3(0, 0, bowl.radius) - bowl.radius * n, n, pace.force};
  });
}

std::vector<SurfaceSample> reach(const Model& plane, const Pace& pace, const Tremor& tremor, double stiffness) {
  std::mt19937 random(tremor.seed);
  const Shake x(random), y(random), z(random);
  constexpr double kWay_s = 2;
  std::vector<SurfaceSample> out = sampled(pace.seconds, pace, [&](double t) {
    const double way = std::fmod(t / kWay_s, 2), tau = way < 1 ? way : 2 - way;
    const double jerk = tau * tau * tau * (10 + tau * (6 * tau - 15)) - 0.5;
    const double press = pace.force - stiffness * tremor.amplitude * z.at(t);
    // Lifted off by the tremor the hand hovers: no contact, no force.
    const double above = std::max(0.0, -press / stiffness);
    const Vec3 p(plane.half * jerk + tremor.amplitude * x.at(t), 0.7 * plane.half * jerk + tremor.amplitude * y.at(t),
                 above);
    return SurfaceSample{0, p, Vec3::UnitZ(), std::max(0.0, press)};
  });
  double farthest = 0;
  for (const SurfaceSample& s : out) farthest = std::max(farthest, s.point.head<2>().cwiseAbs().maxCoeff());
  if (farthest > plane.half) {  // Where nothing is felt, and the truth would be that of a larger plane.
    throw Failure("reach, tremor",
                  fmt::format("the way reaches {:.3g} m, and the plane ends at {:g} m", farthest, plane.half),
                  "less tremor, or a larger half of the plane");
  }
  return out;
}

}  // namespace haptic_bench
