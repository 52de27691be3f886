#include "tools/hapticctl-cut/cut_surface.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace hapticctl_cut {
namespace {

constexpr int kWaves = 24;
constexpr double kTurn = 2 * EIGEN_PI;

/** From 0 to below 1, the same with every standard library. */
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

}  // namespace

CutSurface::CutSurface(const CutShape& shape) : shape_(shape) {
  shape_.pull.stableNormalize();  // However long: the square of 1e200 would leave no direction.
  if (!(shape_.noise > 0)) return;
  const Vec3 u = shape_.pull.unitOrthogonal(), v = shape_.pull.cross(u);
  std::mt19937_64 random(shape_.seed);
  for (int i = 0; i < kWaves; ++i) {
    const double direction = kTurn * uniform(random);
    const double k = kTurn / shape_.wavelength * (0.5 + 0.5 * uniform(random));
    const double phase = kTurn * uniform(random);
    wave_.push_back({k * (std::cos(direction) * u + std::sin(direction) * v), phase});
  }
  amplitude_ = shape_.noise * std::sqrt(2.0 / kWaves);
  reach_ = amplitude_ * kWaves;
}

double CutSurface::at(const Vec3& x) const {
  const Vec3 d = x - shape_.at;
  Vec3 gradient = shape_.pull;
  double value = shape_.pull.dot(d);
  if (shape_.shell) {
    const double r = d.norm();
    value = shape_.radius - r;
    gradient = r > 0 ? Vec3(-d / r) : Vec3(-shape_.pull);
  }
  // Beyond twice the reach the sign is sure, and so is that of all neighbours within the reach.
  if (wave_.empty() || std::abs(value) > 2 * reach_) return value;
  for (const Wave& wave : wave_) {
    const double a = wave.k.dot(d) + wave.phase;
    value += amplitude_ * std::cos(a);
    gradient -= amplitude_ * std::sin(a) * wave.k;
  }
  return value / std::max(gradient.norm(), 0.1);
}

Box CutSurface::box() const {
  if (!shape_.shell) return {Vec3::Constant(-INFINITY), Vec3::Constant(INFINITY)};
  const Vec3 half = Vec3::Constant(shape_.radius + reach_);
  return {shape_.at - half, shape_.at + half};
}

}  // namespace hapticctl_cut
