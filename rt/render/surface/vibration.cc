#include "rt/render/surface/vibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr double kWeightRounding = 1e-9;  // Of a weight.

/** Barycentric coordinates of a point in the plane of speed and force; the triangle has an area. */
std::array<double, 3> weightsIn(const VibrationView& view, std::uint32_t triangle, double speed, double force) HD_RT {
  const VibrationView::Corners& corner = view.triangle[triangle];
  const VibrationModel &a = view.model[corner[0]], &b = view.model[corner[1]], &c = view.model[corner[2]];
  const double area = (b.speed - a.speed) * (c.force - a.force) - (b.force - a.force) * (c.speed - a.speed);
  const double wb = ((speed - a.speed) * (c.force - a.force) - (force - a.force) * (c.speed - a.speed)) / area;
  const double wc = ((b.speed - a.speed) * (force - a.force) - (b.force - a.force) * (speed - a.speed)) / area;
  return {1 - wb - wc, wb, wc};
}

/** Whether a point of those weights is in the triangle, but for rounding. */
bool isWithin(const std::array<double, 3>& w) HD_RT {
  return w[0] >= -kWeightRounding && w[1] >= -kWeightRounding && w[2] >= -kWeightRounding;
}

/** Of the edge nearest to the point, and its triangle. Speeds and forces count as parts of all that were recorded. */
std::array<double, 3> weightsOnEdge(const VibrationView& view, double speed, double force,
                                    std::uint32_t& triangle) HD_RT {
  const double per_speed = 1 / (view.most_speed - view.least_speed);
  const double per_force = 1 / (view.most_force - view.least_force);
  std::array<double, 3> weights{1, 0, 0};
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; t < view.triangles; ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const VibrationModel &from = view.model[view.triangle[t][i]], &to = view.model[view.triangle[t][(i + 1) % 3]];
      const double x = per_speed * (speed - from.speed), y = per_force * (force - from.force);
      const double along_x = per_speed * (to.speed - from.speed), along_y = per_force * (to.force - from.force);
      const double part = std::clamp((x * along_x + y * along_y) / (along_x * along_x + along_y * along_y), 0.0, 1.0);
      const double off_x = x - part * along_x, off_y = y - part * along_y, distance = off_x * off_x + off_y * off_y;
      if (!(distance < nearest)) continue;
      nearest = distance;
      triangle = t;
      weights.fill(0);
      weights[i] = 1 - part;
      weights[(i + 1) % 3] = part;
    }
  }
  return weights;
}

}  // namespace

/**
 * The triangle that holds the point, or holds the place of all edges nearest to it: where the triangles leave out a
 * corner of what was recorded, what is heard changes steadily beyond them too.
 */
Vibration::Mix Vibration::mixAt(const VibrationView& view, double speed, double force) HD_RT {
  if (triangle_ >= view.triangles) triangle_ = 0;
  std::array<double, 3> best = weightsIn(view, triangle_, speed, force);
  for (std::uint32_t t = 0; t < view.triangles && !isWithin(best); ++t) {
    const std::array<double, 3> w = weightsIn(view, t, speed, force);
    if (!isWithin(w)) continue;
    best = w;
    triangle_ = t;
  }
  if (!isWithin(best)) best = weightsOnEdge(view, speed, force, triangle_);
  double sum = 0;
  for (double& w : best) sum += w = std::max(w, 0.0);
  Mix mix;
  for (std::size_t i = 0; i < 3; ++i) {
    mix.model[i] = &view.model[view.triangle[triangle_][i]];
    mix.weight[i] = best[i] / sum;
  }
  return mix;
}

/** Zero mean, unit variance, within 2 sqrt(3): the sum of four uniform numbers from one step of SplitMix64. */
double Vibration::whiteNoise() HD_RT {
  std::uint64_t z = (noise_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  const std::uint64_t sum = (z & 0xffff) + (z >> 16 & 0xffff) + (z >> 32 & 0xffff) + (z >> 48);
  constexpr double kMean = 2 * 65535.0;
  constexpr double kDeviation = 37837.22;  // sqrt(4 (65536^2 - 1) / 12)
  return (static_cast<double>(sum) - kMean) / kDeviation;
}

double Vibration::step(const VibrationView& view, double speed, double force) HD_RT {
  const Mix mix = mixAt(view, std::clamp(speed, view.least_speed, view.most_speed),
                        std::clamp(force, view.least_force, view.most_force));
  double power = 0;
  std::array<double, kVibrationOrder> k{};
  for (std::size_t m = 0; m < 3; ++m) {
    power += mix.weight[m] * mix.model[m]->power;
    for (std::size_t i = 0; i < kVibrationOrder; ++i) k[i] += mix.weight[m] * mix.model[m]->reflection[i];
  }
  // Each section turns the pair of its two signals: no energy comes from nowhere, even when the models change.
  double y = whiteNoise();
  for (std::size_t i = kVibrationOrder; i > 0; --i) {
    const double sine = k[i - 1], cosine = std::sqrt(1 - sine * sine);
    const double forward = y, backward = state_[i - 1];
    y = cosine * forward - sine * backward;
    state_[i] = sine * forward + cosine * backward;
  }
  state_[0] = y;
  // Below the slowest and lightest model it fades away in proportion.
  const double fade = (view.least_speed > 0 ? std::min(1.0, speed / view.least_speed) : 1.0) *
                      (view.least_force > 0 ? std::min(1.0, force / view.least_force) : 1.0);
  return speed > 0 && force > 0 ? fade * std::sqrt(power) * y : 0.0;
}

}  // namespace hapticd
