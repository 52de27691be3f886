#include "rt/render/surface/relief.h"

#include <cmath>
#include <cstdint>

namespace hapticd {
namespace {

/** Quadratic B-spline over the three pixels about a coordinate counted in pixels. */
struct Taps {
  std::uint32_t index[3];
  double weight[3];
  double slope[3];  ///< Derivative of the weight.
};

/** The pixel that stands at place i of a row that goes to and fro over `count` pixels. */
std::uint32_t mirrored(double i, std::uint32_t count) HD_RT {
  const double period = 2.0 * count;
  const double at = i - period * std::floor(i / period);  // Exact for all that can be touched.
  if (!(at >= 0 && at < period)) return 0;                // Beyond: of a recording that somebody made up.
  const auto k = static_cast<std::uint32_t>(at);
  return k < count ? k : 2 * count - 1 - k;
}

Taps tapsAt(double coordinate, std::uint32_t count) HD_RT {
  const double middle = std::floor(coordinate);  // Pixel k covers k to k + 1.
  const double t = coordinate - middle - 0.5;
  Taps taps;
  for (int i = 0; i < 3; ++i) taps.index[i] = mirrored(middle + (i - 1), count);
  taps.weight[0] = 0.5 * (0.5 - t) * (0.5 - t);
  taps.weight[1] = 0.75 - t * t;
  taps.weight[2] = 0.5 * (0.5 + t) * (0.5 + t);
  taps.slope[0] = t - 0.5;
  taps.slope[1] = -2 * t;
  taps.slope[2] = t + 0.5;
  return taps;
}

/** Grey between 0 and 1 at (u, v), metres from the picture's middle, and its derivatives by them. */
struct Grey {
  double value = 0, by_u = 0, by_v = 0;
};

Grey greyAt(const ReliefView& relief, const SurfaceParameters& surface, double u, double v) HD_RT {
  const double per_u = relief.width / surface.relief_size[0];
  const double per_v = relief.height / surface.relief_size[1];
  const Taps across = tapsAt(0.5 * relief.width + u * per_u, relief.width);
  const Taps down = tapsAt(0.5 * relief.height - v * per_v, relief.height);
  Grey grey;
  for (int j = 0; j < 3; ++j) {
    const std::uint16_t* row = relief.pixel + std::size_t{down.index[j]} * relief.width;
    double value = 0, slope = 0;
    for (int i = 0; i < 3; ++i) {
      const double g = row[across.index[i]];
      value += across.weight[i] * g;
      slope += across.slope[i] * g;
    }
    grey.value += down.weight[j] * value;
    grey.by_u += down.weight[j] * slope;
    grey.by_v -= down.slope[j] * value;
  }
  constexpr double kPerGrey = 1.0 / 65535;
  grey.value *= kPerGrey;
  grey.by_u *= kPerGrey * per_u;
  grey.by_v *= kPerGrey * per_v;
  return grey;
}

}  // namespace

ReliefPoint reliefAt(const ReliefView& relief, const SurfaceParameters& surface, const Vec3& x, const Vec3& n) HD_RT {
  constexpr int kAcross[3] = {1, 0, 0}, kUp[3] = {2, 2, 1};  // Axes along which the picture lies.
  const Vec3 nn = n.cwiseProduct(n);
  const Vec3 weight = nn.cwiseProduct(nn) / nn.squaredNorm();
  ReliefPoint point;
  for (int axis = 0; axis < 3; ++axis) {
    if (weight[axis] == 0) continue;
    const Grey grey = greyAt(relief, surface, x[kAcross[axis]], x[kUp[axis]]);
    const double share = weight[axis] * surface.relief_depth;
    point.height += share * (grey.value - 1);
    point.gradient[kAcross[axis]] += share * grey.by_u;
    point.gradient[kUp[axis]] += share * grey.by_v;
  }
  return point;
}

}  // namespace hapticd
