/** @file
 * The vectors of the real-time code: double precision, SI, right-handed. Names carry frames: p_WT is the origin of T in
 * W; X_WT takes coordinates in T to W.
 */
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "rt/base/contract.h"

namespace hapticd {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/** Force and torque about the same point, in the same frame [N, N m]. */
struct Wrench {
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
};

/** Linear and angular velocity [m/s, rad/s]. */
struct Twist {
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();
};
[[nodiscard]] inline bool isZero(const Twist& V) HD_RT { return V.v.isZero(0) && V.w.isZero(0); }

/** A rigid transform: x_A = q x_B + p. */
struct Pose {
  Vec3 p = Vec3::Zero();
  Quat q = Quat::Identity();

  [[nodiscard]] Vec3 operator*(const Vec3& x) const HD_RT { return q * x + p; }
  [[nodiscard]] Pose operator*(const Pose& other) const HD_RT { return {q * other.p + p, (q * other.q).normalized()}; }
  [[nodiscard]] Pose inverse() const HD_RT {
    const Quat r = q.conjugate();
    return {-(r * p), r};
  }
};

[[nodiscard]] inline bool isFinite(const Vec3& x) HD_RT { return x.allFinite(); }
[[nodiscard]] inline bool isFinite(const Quat& q) HD_RT { return q.coeffs().allFinite(); }

/**
 * x as a float holds it. Not by a cast there and back: g++ 12 takes two of these side by side for nothing at all (at
 * -O2, where it makes a vector of them).
 */
[[nodiscard]] inline double asFloat(double x) HD_RT {
  const volatile float stored = static_cast<float>(x);
  return stored;
}
[[nodiscard]] inline Vec3 asFloat(const Vec3& x) HD_RT { return {asFloat(x.x()), asFloat(x.y()), asFloat(x.z())}; }

/** x shortened to at most `limit`, direction kept. Needs finite x, limit >= 0. */
[[nodiscard]] inline Vec3 clampNorm(const Vec3& x, double limit) HD_RT {
  const double n = x.norm();
  return n > limit ? Vec3(x * (limit / n)) : x;
}

/** A power or an energy along `direction`, by axis: as the squares of its parts, which sum to all; along none a third.
 */
[[nodiscard]] inline Vec3 byAxis(double amount, const Vec3& direction) HD_RT {
  const double squared = direction.squaredNorm();
  return squared > 1e-24 ? Vec3(amount / squared * direction.cwiseProduct(direction)) : Vec3::Constant(amount / 3);
}

/** The rotation after `dt` seconds at angular velocity w (same frame as q's target). Exact for constant w. */
[[nodiscard]] inline Quat rotated(const Quat& q, const Vec3& w, double dt) HD_RT {
  const double angle = w.norm() * dt;
  if (angle < 1e-12) return q;
  return (Quat(Eigen::AngleAxisd(angle, w.normalized())) * q).normalized();
}

[[nodiscard]] inline Vec3 vec3(const double (&x)[3]) HD_RT { return {x[0], x[1], x[2]}; }
[[nodiscard]] inline Quat quat(const double (&q)[4]) HD_RT { return {q[0], q[1], q[2], q[3]}; }
inline void store(const Vec3& x, double (&out)[3]) HD_RT {
  out[0] = x.x();
  out[1] = x.y();
  out[2] = x.z();
}
inline void store(const Quat& q, double (&out)[4]) HD_RT {
  out[0] = q.w();
  out[1] = q.x();
  out[2] = q.y();
  out[3] = q.z();
}

}  // namespace hapticd
