#include "rt/cycle/velocity_estimator.h"

#include <algorithm>
#include <limits>

namespace hapticd {
namespace {

constexpr double kRounded = 1 + 0x1p-10;  // [steps] So near, readings count as one step apart: floats round.

/**
 * The end-fit line of one axis, which takes samples from the newest on. The slopes of the lines that pass all of them
 * within the resolution are an interval, which each sample narrows: each is looked at once.
 */
class EndFit {
 public:
  /** A sample, relative to the newest, and 1 / its age [1/s]. False: the window has ended. */
  bool take(double y, double rate, double resolution) HD_RT {
    const double slope = -y * rate;
    ended_ = ended_ || !(slope >= least_ && slope <= most_);
    if (ended_) return false;
    slope_ = slope;
    least_ = std::max(least_, slope - resolution * rate);
    most_ = std::min(most_, slope + resolution * rate);
    return true;
  }
  [[nodiscard]] double slope() const HD_RT { return slope_; }

 private:
  double least_ = -std::numeric_limits<double>::infinity(), most_ = -least_;
  double slope_ = 0;
  bool ended_ = false;
};

/** Whether the window of any axis goes on. */
bool takeEach(std::array<EndFit, 3>& axis, const Vec3& y, double rate, double resolution) HD_RT {
  bool any = false;
  for (int i = 0; i < 3; ++i) any = axis[i].take(y[i], rate, resolution) || any;
  return any;
}

/** Axis times angle of the rotation from `from` to `to`, in the frame of their targets, the short way. */
Vec3 rotationBetween(const Quat& from, const Quat& to) HD_RT {
  if (to.coeffs() == from.coeffs()) return Vec3::Zero();
  Quat d = to * from.conjugate();
  if (d.w() < 0) d.coeffs() = -d.coeffs();
  const double s = d.vec().norm();
  // angle / sin(angle / 2) tends to 2 as the angle vanishes.
  const double scale = s > 1e-9 ? 2 * std::atan2(s, d.w()) / s : 2;
  return scale * d.vec();
}

}  // namespace

void VelocityEstimator::reset() HD_RT {
  count_ = unturned_ = 0;
  last_ = Twist{};
}

void VelocityEstimator::setResolution(double position, double rotation) HD_RT {
  if (std::isfinite(position) && position > 0) resolution_ = kRounded * position;
  if (std::isfinite(rotation) && rotation > 0) rotation_resolution_ = kRounded * rotation;
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
    unturned_ = count_ > 0 && sample.q.coeffs() == back(0).q.coeffs() ? std::min(unturned_ + 1, kWindow) : 1;
    ring_[next_] = {sample.t_ns, sample.p, sample.q};
    next_ = (next_ + 1) % kWindow;
    count_ = std::min(count_ + 1, kWindow);
  }
  if (sample.has_velocity) {
    last_ = {sample.v, sample.w};
    return last_;
  }

  std::array<EndFit, 3> along, about;
  const Entry& newest = back(0);
  bool moves = true, turns = unturned_ < count_;  // It never does on a device that senses no rotation.
  for (std::uint32_t n = 1; n < count_ && (moves || turns); ++n) {
    const Entry& e = back(n);
    const double rate = 1e9 / static_cast<double>(newest.t_ns - e.t_ns);
    if (moves) moves = takeEach(along, e.p - newest.p, rate, resolution_);
    if (turns) turns = takeEach(about, -rotationBetween(e.q, newest.q), rate, rotation_resolution_);
  }
  for (int i = 0; i < 3; ++i) {
    last_.v[i] = along[i].slope();
    last_.w[i] = about[i].slope();
  }
  return last_;
}

}  // namespace hapticd
