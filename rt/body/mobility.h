/** @file
 * How a body answers an impulse over one step: the inverse of its 6 x 6 mass, in 3 x 3 blocks about its centre of mass
 * and in the world frame. A tool's mass includes the implicit part of what holds it (coupling.h).
 */
#pragma once

#include "rt/base/math.h"
#include "rt/base/rotation.h"

namespace hapticd {

/** Symmetric, positive semidefinite. All zero: a body that nothing moves. */
struct Mobility {
  Mat3 vp = Mat3::Zero();  ///< Velocity of C per impulse at C [1/kg].
  Mat3 vl = Mat3::Zero();  ///< Velocity of C per angular impulse.
  Mat3 wl = Mat3::Zero();  ///< Angular velocity per angular impulse [1/(kg m^2)].

  /** Of a free body. */
  [[nodiscard]] static Mobility free(double mass, const Mat3& inertia) HD_RT {
    Mobility out;
    out.vp = Mat3::Identity() / mass;
    out.wl = inertia.inverse();
    return out;
  }

  /** What an impulse p and an angular impulse l about C add to the motion. */
  [[nodiscard]] Twist operator()(const Vec3& p, const Vec3& l) const HD_RT {
    return {vp * p + vl * l, vl.transpose() * p + wl * l};
  }
  /** Velocity at r (from C) per impulse there: symmetric. Eq. (3.7)'s denominator is n . at(r) n, with full inertia. */
  [[nodiscard]] Mat3 at(const Vec3& r) const HD_RT {
    const Mat3 X = crossMatrix(r);
    return vp + vl * X - X * vl.transpose() - X * wl * X;
  }
};

[[nodiscard]] inline Vec3 velocityAt(const Twist& V, const Vec3& r) HD_RT { return V.v + V.w.cross(r); }

}  // namespace hapticd
