#include "drivers/sim/motion.h"

#include <algorithm>

#include "drivers/sim/body.h"

namespace hapticd {
namespace {

constexpr double kTwoPi = 2 * EIGEN_PI;
constexpr double kFarthest_m = 10;  ///< Of a client's wish, on each axis: no hand's own limits are there.

/** Counter-based pseudo-random bits: the n-th draw of a seed (SplitMix64; Steele, Lea, Flood, OOPSLA 2014). */
std::uint64_t draw(std::uint64_t seed, std::uint64_t n) HD_RT {
  std::uint64_t z = seed * 0xd1342543de82ef95u + (n + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/** Uniform in [0, 1). */
double uniform(std::uint64_t seed, std::uint64_t n) HD_RT { return static_cast<double>(draw(seed, n) >> 11) * 0x1p-53; }

constexpr std::uint64_t kTremorDraws = std::uint64_t{1} << 62;  ///< Apart from the draws of the targets.

}  // namespace

MotionKind motionKind(std::string_view name) noexcept {
  int kind = 0;
  for (std::string_view rest = kMotionNames;;) {
    const std::size_t bar = rest.find('|');
    if (rest.substr(0, bar) == name) return static_cast<MotionKind>(kind);
    if (bar == std::string_view::npos) return MotionKind::kLive;
    rest.remove_prefix(bar + 1);
    ++kind;
  }
}

IntendedMotion::IntendedMotion(const MotionParameters& parameters) : parameters_(parameters) {
  orientation_ = fromRotationVector(parameters_.orientation);
  parameters_.direction.normalize();
  const Vec3 n = parameters_.normal.normalized();
  // Start toward the base axis that lies flattest in the plane; about z the circle starts at +x toward +y.
  int flattest = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(n[i]) < std::abs(n[flattest]) - 1e-9) flattest = i;
  }
  const Vec3 axis = Vec3::Unit(flattest);
  circle_u_ = (axis - n * n.dot(axis)).normalized();
  circle_v_ = n.cross(circle_u_);
  std::uint64_t n_draw = kTremorDraws;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < kTremorTones; ++k) {
      // Physiological tremor of the hand lies at 8-12 Hz (Elble and Koller, Tremor, Johns Hopkins 1990).
      tone_rate_[i][k] = kTwoPi * (8 + 4 * uniform(parameters_.seed, n_draw));
      tone_phase_[i][k] = kTwoPi * uniform(parameters_.seed, n_draw + 1);
      n_draw += 2;
    }
  }
  live_.p = parameters_.centre;
  live_.q = orientation_;
  live_.gripper_rad = parameters_.gripper_angle;
}

void IntendedMotion::setLive(const DeviceIntent& intent) HD_RT {
  if (parameters_.kind != MotionKind::kLive) return;
  // Written so that NaN fails: within 10 rad, and a quaternion that means something.
  const double norm = intent.q.norm();
  const bool sane = isFinite(intent.p) && norm > 0.5 && norm < 2 && std::abs(intent.gripper_rad) <= 10;
  if (!sane) return;
  live_.p = intent.p.cwiseMax(-kFarthest_m).cwiseMin(kFarthest_m);
  live_.q = intent.q.normalized();
  live_.gripper_rad = intent.gripper_rad;
}

Vec3 IntendedMotion::target(std::uint64_t n) const HD_RT {
  const Vec3 extent = parameters_.box_upper - parameters_.box_lower;
  Vec3 point;
  for (int i = 0; i < 3; ++i) {
    point[i] = parameters_.box_lower[i] + extent[i] * uniform(parameters_.seed, 3 * n + static_cast<unsigned>(i));
  }
  return point;
}

void IntendedMotion::minimumJerk(double t_s, PoseOnTrack& out) const HD_RT {
  // Point to point with least integrated squared jerk: Flash and Hogan, J. Neuroscience 5(7), 1985, eq. (3).
  const double strokes = t_s / parameters_.period;
  const double n = std::floor(strokes);
  const double s = strokes - n;
  const Vec3 a = target(static_cast<std::uint64_t>(n));
  const Vec3 reach = target(static_cast<std::uint64_t>(n) + 1) - a;
  const double s2 = s * s;
  out.p = a + reach * (s2 * s * (10 - 15 * s + 6 * s2));
  out.v = reach * (30 * s2 * (1 - 2 * s + s2) / parameters_.period);
}

void IntendedMotion::path(double t_s, PoseOnTrack& out) const HD_RT {
  const MotionParameters& m = parameters_;
  const double rate = kTwoPi / m.period;
  const double angle = rate * t_s;
  switch (m.kind) {
    case MotionKind::kTap: {
      // At rest for the first half of each period, down and up in the second.
      const double turn = t_s / m.period - std::floor(t_s / m.period);
      if (turn < 0.5) break;
      const double dip = 2 * kTwoPi * (turn - 0.5);
      out.p += m.direction * (m.depth * 0.5 * (1 - std::cos(dip)));
      out.v += m.direction * (m.depth * rate * std::sin(dip));
      break;
    }
    case MotionKind::kStroke:
      out.p = m.from + (m.to - m.from) * (0.5 * (1 - std::cos(angle)));
      out.v = (m.to - m.from) * (0.5 * rate * std::sin(angle));
      break;
    case MotionKind::kCircle:
      out.p += m.radius * (std::cos(angle) * circle_u_ + std::sin(angle) * circle_v_);
      out.v += m.radius * rate * (std::cos(angle) * circle_v_ - std::sin(angle) * circle_u_);
      break;
    case MotionKind::kLissajous:
      for (int i = 0; i < 3; ++i) {
        out.p[i] += m.amplitude[i] * std::sin(m.ratio[i] * angle + m.phase[i]);
        out.v[i] += m.amplitude[i] * m.ratio[i] * rate * std::cos(m.ratio[i] * angle + m.phase[i]);
      }
      break;
    case MotionKind::kMinJerk:
      minimumJerk(t_s, out);
      break;
    case MotionKind::kHold:
    case MotionKind::kLive:
    case MotionKind::kCsv:
      break;
  }
  const double swing = std::sin(angle);
  out.q = fromRotationVector(m.sway * swing) * orientation_;
  out.w = m.sway * (rate * std::cos(angle));
}

void IntendedMotion::addTremor(double t_s, PoseOnTrack& out) const HD_RT {
  if (parameters_.tremor <= 0) return;
  const double each = parameters_.tremor / kTremorTones;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < kTremorTones; ++k) {
      const double angle = tone_rate_[i][k] * t_s + tone_phase_[i][k];
      out.p[i] += each * std::sin(angle);
      out.v[i] += each * tone_rate_[i][k] * std::cos(angle);
    }
  }
}

PoseOnTrack IntendedMotion::at(double t_s) const HD_RT {
  if (parameters_.kind == MotionKind::kLive) return live_;
  // Before its first row the track stands.
  if (parameters_.track) return parameters_.track->at(t_s - parameters_.wait, parameters_.loop);
  const double t = std::max(0.0, t_s - parameters_.wait);
  PoseOnTrack out;
  out.p = parameters_.centre;
  out.gripper_rad = parameters_.gripper_angle;
  path(t, out);
  if (t_s < parameters_.wait) {
    out.v.setZero();
    out.w.setZero();
  }
  addTremor(t_s, out);
  return out;
}

}  // namespace hapticd
