/** @file
 * One exact step of m x'' + c x' + k x = u with dry friction: the kernel of the simulated device.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/**
 * The exact discrete solution of m x'' + c x' + k x = u over a step h with u constant:
 * x1 = xx x + xv v + xu u, v1 = vx x + vv v + vu u. Exact at any stiffness, so no step size makes it unstable.
 */
struct LinearStep {
  double xx = 1, xv = 0, xu = 0;
  double vx = 0, vv = 1, vu = 0;

  /** Matrix exponential by scaling and squaring. mass > 0, the others >= 0. Control thread. */
  [[nodiscard]] static LinearStep make(double mass, double damping, double stiffness, double step_s);

  /**
   * Advances x and v under u and a dry friction of at most `coulomb` that opposes the motion (maximum dissipation,
   * isotropic). Friction is implicit: the one constant force that brings v to zero at the end of the step if it is
   * strong enough, else full strength against the velocity the step would end with (Moreau's time stepping; Acary and
   * Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, Springer 2008, chapter 10). It therefore sticks
   * without chatter (Karnopp's dead band of zero width) and stops where the closed form says, to second order in h.
   */
  void advance(Vec3& x, Vec3& v, const Vec3& u, double stiffness, double coulomb) const HD_RT {
    if (coulomb > 0 && v.squaredNorm() == 0) {
      // At rest: it stays exactly where it is while the net force is within the friction.
      if ((u - stiffness * x).squaredNorm() <= coulomb * coulomb) return;
    }
    const Vec3 x_free = xx * x + xv * v + xu * u;
    const Vec3 v_free = vx * x + vv * v + vu * u;
    if (coulomb <= 0) {
      x = x_free;
      v = v_free;
      return;
    }
    const double speed = v_free.norm();
    const double slowed = vu * coulomb;  // What full friction takes from the speed in one step.
    if (speed <= slowed) {
      x = x_free - v_free * (xu / vu);
      v.setZero();
    } else {
      const Vec3 direction = v_free / speed;
      x = x_free - direction * (xu * coulomb);
      v = v_free - direction * slowed;
    }
  }
};

}  // namespace hapticd
