#include "rt/body/constraint_row.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

void applyPair(const Mobility& a, const Mobility& b, const Touch& touch, const Vec3& j, Twist& V_a, Twist& V_b) HD_RT {
  const Twist da = a(j, touch.r_a.cross(j));
  const Twist db = b(j, touch.r_b.cross(j));
  V_a.v += da.v;
  V_a.w += da.w;
  V_b.v -= db.v;
  V_b.w -= db.w;
}

void prepareRow(const Mobility& a, const Mobility& b, const Touch& touch, double dt, ConstraintRow& row) HD_RT {
  const Vec3 t = touch.n.unitOrthogonal();
  row.axes.col(0) = touch.n;
  row.axes.col(1) = t;
  row.axes.col(2) = touch.n.cross(t);
  row.K = row.axes.transpose() * (a.at(touch.r_a) + b.at(touch.r_b)) * row.axes;
  row.give = touch.give > 0 ? touch.give / (dt * dt) : 0;
  row.target = touch.give > 0 ? -touch.gap / dt : touch.target(dt);
  const double xx = row.K(1, 1);
  const double yy = row.K(2, 2);
  const double xy = row.K(1, 2);
  row.tangent = 0.5 * (xx + yy) + std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  const double determinant = xx * yy - xy * xy;
  const double scale = determinant > 0 ? 1 / determinant : 0;
  row.inverse_tt[0] = yy * scale;
  row.inverse_tt[1] = xx * scale;
  row.inverse_tt[2] = -xy * scale;
}

Vec3 startRow(const ConstraintRow& row, const Touch& touch, const Vec3& impulse) HD_RT {
  Vec3 lambda = row.axes.transpose() * impulse;
  lambda[0] = std::max(0.0, lambda[0]);
  const double across = std::hypot(lambda[1], lambda[2]);
  const double limit = touch.friction * lambda[0];
  if (across > limit) lambda.tail<2>() *= limit / across;
  return lambda;
}

double relaxRow(const Mobility& a, const Mobility& b, const Touch& touch, const ConstraintRow& row, Vec3& lambda,
                Twist& V_a, Twist& V_b) HD_RT {
  if (!(row.K(0, 0) > 0)) return 0;
  Vec3 u = row.axes.transpose() * relativeVelocity(V_a, V_b, touch);
  Vec3 next = lambda;
  const double missing = row.target - u[0] - row.give * lambda[0];
  next[0] = std::max(0.0, lambda[0] + missing / (row.K(0, 0) + row.give));
  u += row.K.col(0) * (next[0] - lambda[0]);
  const double limit = touch.friction * next[0];
  if (limit > 0 && row.tangent > 0) {
    const double x = next[1] - (row.inverse_tt[0] * u[1] + row.inverse_tt[2] * u[2]);
    const double y = next[2] - (row.inverse_tt[2] * u[1] + row.inverse_tt[1] * u[2]);
    if (x * x + y * y <= limit * limit) {
      next[1] = x;
      next[2] = y;
    } else {
      // Outside the disc a projected step of the gradient: it cannot overshoot.
      next[1] -= u[1] / row.tangent;
      next[2] -= u[2] / row.tangent;
      const double size = std::sqrt(next[1] * next[1] + next[2] * next[2]);
      if (size > limit) {
        next[1] *= limit / size;
        next[2] *= limit / size;
      }
    }
  } else {
    next[1] = next[2] = 0;
  }
  const Vec3 change = next - lambda;
  if (change.isZero(0)) return 0;
  applyPair(a, b, touch, row.axes * change, V_a, V_b);
  lambda = next;
  return (row.K * change).cwiseAbs().maxCoeff();
}

}  // namespace hapticd
