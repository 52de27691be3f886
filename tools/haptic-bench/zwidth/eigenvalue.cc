#include "tools/haptic-bench/zwidth/eigenvalue.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "drivers/sim/linear_step.h"
#include "rt/cycle/velocity_estimator.h"

namespace haptic_bench::zwidth {

double spectralRadius(const Loop& loop, double stiffness, double damping, std::uint32_t window) {
  const hapticd::SimParameters& p = loop.device.parameters;
  const double tick_s = 1 / loop.rate_hz;
  const auto step =
      hapticd::LinearStep::make(p.mass + p.hand_mass, p.viscous + p.hand_damping, p.hand_stiffness, tick_s);
  // State: x, v, then x of the last `window` ticks, then the forces under way, the oldest last. All as lengths, v as
  // its way in a tick, a force as T^2 / m of it: eigenvalues of a matrix whose entries differ by 1e5 lose half their
  // digits.
  const double length = tick_s * tick_s / (p.mass + p.hand_mass);
  const auto m = static_cast<Eigen::Index>(window), d = static_cast<Eigen::Index>(loop.delay);
  const Eigen::Index size = 2 + m + d;
  Eigen::RowVectorXd law = Eigen::RowVectorXd::Zero(size);
  const double gain = damping / (static_cast<double>(window) * tick_s);
  law(0) = -(stiffness + gain) * length;
  law(2 + m - 1) = gain * length;
  Eigen::RowVectorXd acting = law;
  if (d > 0) acting = Eigen::RowVectorXd::Unit(size, size - 1);

  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(size, size);
  a(0, 0) = step.xx;
  a(0, 1) = step.xv / tick_s;
  a(1, 0) = step.vx * tick_s;
  a(1, 1) = step.vv;
  a.row(0) += step.xu / length * acting;
  a.row(1) += step.vu * tick_s / length * acting;
  a(2, 0) = 1;
  for (Eigen::Index i = 1; i < m; ++i) a(2 + i, 1 + i) = 1;
  if (d > 0) a.row(2 + m) = law;
  for (Eigen::Index i = 1; i < d; ++i) a(2 + m + i, 1 + m + i) = 1;
  return a.eigenvalues().cwiseAbs().maxCoeff();
}

namespace {

/** The highest stable stiffness at or below `from` [N/m]. */
double limitBelow(const Loop& loop, double damping, std::uint32_t window, double from) {
  const auto stable = [&](double k) { return spectralRadius(loop, k, damping, window) < 1; };
  constexpr double kStride = 1.05, kSoftest = 1;
  double low = from;
  while (!stable(low)) {
    low /= kStride;
    if (low < kSoftest) return 0;
  }
  if (low == from) return from;
  double high = low * kStride;
  while (high - low > 1e-6 * high) {
    const double middle = std::sqrt(low * high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

double eigenvalueLimit(const Loop& loop, double damping, std::uint32_t window) {
  // A held spring alone turns a mass round within a tick beyond 4 m / T^2; no damping makes that stable.
  const double mass = loop.device.parameters.mass + loop.device.parameters.hand_mass;
  return limitBelow(loop, damping, window, 8 * mass * loop.rate_hz * loop.rate_hz);
}

double slowestLimit(const Loop& loop, double damping) {
  double least = eigenvalueLimit(loop, damping);
  for (std::uint32_t m = 2; m < hapticd::VelocityEstimator::kWindow && damping > 0; ++m) {
    least = limitBelow(loop, damping, m, least);
  }
  return least;
}

}  // namespace haptic_bench::zwidth
