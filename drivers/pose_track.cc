#include "drivers/pose_track.h"

#include <algorithm>

namespace hapticd {
namespace {

/** Rotation vector of the short way from a to b, in the frame they are expressed in. */
Vec3 shortWay(const Quat& a, const Quat& b) HD_RT {
  Quat d = b * a.conjugate();
  if (d.w() < 0) d.coeffs() = -d.coeffs();
  const double sine = d.vec().norm();
  return sine < 1e-12 ? Vec3(2 * d.vec()) : Vec3(d.vec() * (2 * std::atan2(sine, d.w()) / sine));
}

}  // namespace

PoseOnTrack PoseTrack::at(double t_s, bool loop) const HD_RT {
  const double end = duration();
  bool moving = end > 0 && t_s >= 0;
  if (loop && moving) {
    t_s -= end * std::floor(t_s / end);
  } else if (t_s >= end) {
    t_s = end;
    moving = false;
  }
  // Bisection: 21 steps at most, whatever the spacing of the rows.
  const auto after =
      std::upper_bound(rows_.begin(), rows_.end(), t_s, [](double t, const PoseRow& row) HD_RT { return t < row.t_s; });
  const PoseRow& a = after == rows_.begin() ? *after : *(after - 1);
  PoseOnTrack out{a.p, Vec3::Zero(), a.q, Vec3::Zero(), a.gripper_rad, a.buttons};
  if (!moving || after == rows_.end() || after == rows_.begin()) return out;
  const PoseRow& b = *after;
  const double span = b.t_s - a.t_s;
  const double s = (t_s - a.t_s) / span;
  out.p = a.p + s * (b.p - a.p);
  out.v = (b.p - a.p) / span;
  const Vec3 turn = shortWay(a.q, b.q);
  out.q = rotated(a.q, turn, s);
  out.w = turn / span;
  out.gripper_rad = a.gripper_rad + s * (b.gripper_rad - a.gripper_rad);
  return out;
}

}  // namespace hapticd
