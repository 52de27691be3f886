/** @file
 * One contact as a unilateral constraint with Coulomb friction in a disc, for projected Gauss-Seidel sweeps: what
 * ConstraintResponse does for two bodies and JointStep for many.
 *
 * A surface that yields (Touch::give, s) is a spring, implicit in time: the force f = -(gap + dt u) / s at the end of
 * the step gives u + lambda s / dt^2 = -gap / dt, a row of the same kind with s / dt^2 on the diagonal.
 */
#pragma once

#include "rt/body/response.h"

namespace hapticd {

struct ConstraintRow {
  Mat3 axes;             ///< Columns: n and two tangents.
  Mat3 K;                ///< Answer to an impulse, in those axes.
  double tangent;        ///< Largest eigenvalue of K's tangential part.
  double inverse_tt[3];  ///< xx, yy, xy of that part's inverse.
  double target;         ///< Least velocity along n [m/s].
  double give;           ///< s / dt^2.
};

void prepareRow(const Mobility& a, const Mobility& b, const Touch& touch, double dt, ConstraintRow& row) HD_RT;

/** An impulse of the former step, in the world, made one that this step's row may begin with: lambda in its axes. */
[[nodiscard]] Vec3 startRow(const ConstraintRow& row, const Touch& touch, const Vec3& impulse) HD_RT;

/** One relaxation: changes lambda and both motions. The largest change of a velocity [m/s]. */
double relaxRow(const Mobility& a, const Mobility& b, const Touch& touch, const ConstraintRow& row, Vec3& lambda,
                Twist& V_a, Twist& V_b) HD_RT;

/** Speed by which the touch misses its target [m/s]. */
[[nodiscard]] inline double lacking(const ConstraintRow& row, const Touch& touch, const Vec3& lambda, const Twist& V_a,
                                    const Twist& V_b) HD_RT {
  return row.target - row.give * lambda[0] - relativeVelocity(V_a, V_b, touch).dot(touch.n);
}

/** Applies an impulse at a touch to both motions. */
void applyPair(const Mobility& a, const Mobility& b, const Touch& touch, const Vec3& j, Twist& V_a, Twist& V_b) HD_RT;

}  // namespace hapticd
