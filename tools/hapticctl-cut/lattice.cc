#include "tools/hapticctl-cut/lattice.h"

#include <algorithm>
#include <cmath>

namespace hapticctl_cut {
namespace {

constexpr double kGrowth = 1.2;  ///< Of a step over that before it: neighbours stay alike.

/** From `from` on, up (1) or down (-1), until `to` is passed by three steps. */
std::vector<double> outward(double sign, double from, double to, double fine, double coarse) {
  std::vector<double> planes;
  double step = fine, x = from;
  for (int beyond = 0; beyond < 3;) {
    step = std::min(step * kGrowth, coarse);
    x += sign * step;
    planes.push_back(x);
    if (sign * (x - to) > 0) ++beyond;
  }
  return planes;
}

}  // namespace

double Lattice::between(std::size_t axis, double number) const {
  const auto& p = plane[axis];
  const double below = std::clamp(std::floor(number), 0.0, static_cast<double>(p.size() - 2));
  const auto i = static_cast<std::size_t>(below);
  return p[i] + (number - below) * (p[i + 1] - p[i]);
}

std::vector<double> Lattice::widths(std::size_t axis) const {
  const auto& p = plane[axis];
  std::vector<double> out(p.size(), 0);
  for (std::size_t i = 1; i < p.size(); ++i) {
    const double step = p[i] - p[i - 1];
    out[i - 1] = std::max(out[i - 1], step);
    out[i] = step;
  }
  return out;
}

Lattice makeLattice(const Box& whole, const Box& detail, double fine, double coarse) {
  Lattice out;
  for (int k = 0; k < 3; ++k) {
    const double from = std::max(detail.lower[k], whole.lower[k] - fine);
    const double to = std::max(from + fine, std::min(detail.upper[k], whole.upper[k] + fine));
    const auto steps = static_cast<std::size_t>(std::ceil((to - from) / fine));
    std::vector<double>& planes = out.plane[static_cast<std::size_t>(k)];
    planes = outward(-1, from, whole.lower[k], fine, coarse);
    std::reverse(planes.begin(), planes.end());
    for (std::size_t i = 0; i <= steps; ++i) planes.push_back(from + static_cast<double>(i) * fine);
    const double last = planes.back();
    const std::vector<double> rest = outward(1, last, whole.upper[k], fine, coarse);
    planes.insert(planes.end(), rest.begin(), rest.end());
  }
  return out;
}

}  // namespace hapticctl_cut
