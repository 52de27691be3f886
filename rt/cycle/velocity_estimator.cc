#include "rt/cycle/velocity_estimator.h"

#include <algorithm>

namespace hapticd {
namespace {

/** Samples of one axis, newest first: y relative to the newest, age in seconds (rising). */
struct Axis {
  std::array<double, VelocityEstimator::kWindow> y;
  std::array<double, VelocityEstimator::kWindow> age;
  std::uint32_t count;
};

/** Slope of the longest end-fit line that stays within `resolution` of each sample between its ends. */
double endFit(const Axis& axis, double resolution) HD_RT {
  double slope = 0;
  for (std::uint32_t n = 1; n < axis.count; ++n) {
    const double candidate = -axis.y[n] / axis.age[n];
    for (std::uint32_t i = 1; i < n; ++i) {
      if (std::abs(axis.y[i] + candidate * axis.age[i]) > resolution) return slope;
    }
    slope = candidate;
  }
  return slope;
}

/** Axis times angle of the rotation from `from` to `to`, in the frame of their targets, the short way. */
Vec3 rotationVector(const Quat& from, const Quat& to) HD_RT {
  Quat d = to * from.conjugate();
  if (d.w() < 0) d.coeffs() = -d.coeffs();
  const double s = d.vec().norm();
  // angle / sin(angle / 2) tends to 2 as the angle vanishes.
  const double scale = s > 1e-9 ? 2 * std::atan2(s, d.w()) / s : 2;
  return scale * d.vec();
}

}  // namespace

void VelocityEstimator::reset() HD_RT {
  next_ = 0;
  count_ = 0;
  last_ = Twist{};
}

void VelocityEstimator::setResolution(double position, double rotation) HD_RT {
  if (std::isfinite(position) && position > 0) resolution_ = position;
  if (std::isfinite(rotation) && rotation > 0) rotation_resolution_ = rotation;
}

Twist VelocityEstimator::update(const DeviceSample& sample) HD_RT {
  if (!sample.fresh) return last_;
  if (!isFinite(sample.p) || !isFinite(sample.q)) return last_;
  if (count_ > 0) {
    const std::int64_t before = back(0).t_ns;
    if (sample.t_ns == before && !sample.has_velocity) return last_;
    if (sample.t_ns < before) reset();
  }
  if (count_ == 0 || sample.t_ns != back(0).t_ns) {
    ring_[next_] = {sample.t_ns, sample.p, sample.q};
    next_ = (next_ + 1) % kWindow;
    count_ = std::min(count_ + 1, kWindow);
  }
  if (sample.has_velocity) {
    last_ = {sample.v, sample.w};
    return last_;
  }

  std::array<Axis, 6> axes;
  const Entry& newest = back(0);
  for (std::uint32_t n = 0; n < count_; ++n) {
    const Entry& e = back(n);
    const double age = static_cast<double>(newest.t_ns - e.t_ns) * 1e-9;
    const Vec3 dp = e.p - newest.p;
    const Vec3 dr = -rotationVector(e.q, newest.q);
    for (int i = 0; i < 3; ++i) {
      axes[i].y[n] = dp[i];
      axes[i + 3].y[n] = dr[i];
      axes[i].age[n] = axes[i + 3].age[n] = age;
    }
  }
  for (int i = 0; i < 3; ++i) {
    axes[i].count = axes[i + 3].count = count_;
    last_.v[i] = endFit(axes[i], resolution_);
    last_.w[i] = endFit(axes[i + 3], rotation_resolution_);
  }
  return last_;
}

}  // namespace hapticd
