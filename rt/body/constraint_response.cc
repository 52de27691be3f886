#include "rt/body/constraint_response.h"

#include <algorithm>

namespace hapticd {

void ConstraintResponse::prepare(const ResponseProblem& problem, const Touch& touch, Row& row) HD_RT {
  const Vec3 t = touch.n.unitOrthogonal();
  row.axes.col(0) = touch.n;
  row.axes.col(1) = t;
  row.axes.col(2) = touch.n.cross(t);
  row.K = row.axes.transpose() * (problem.a.at(touch.r_a) + problem.b.at(touch.r_b)) * row.axes;
  const double xx = row.K(1, 1);
  const double yy = row.K(2, 2);
  const double xy = row.K(1, 2);
  row.tangent = 0.5 * (xx + yy) + std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
  const double determinant = xx * yy - xy * xy;
  const double scale = determinant > 0 ? 1 / determinant : 0;
  row.inverse_tt.setZero();
  row.inverse_tt(0, 0) = yy * scale;
  row.inverse_tt(1, 1) = xx * scale;
  row.inverse_tt(0, 1) = row.inverse_tt(1, 0) = -xy * scale;
}

double ConstraintResponse::relax(const ResponseProblem& problem, const Touch& touch, const Row& row, Vec3& lambda,
                                 Twist& a, Twist& b) HD_RT {
  if (!(row.K(0, 0) > 0)) return 0;
  Vec3 u = row.axes.transpose() * relativeVelocity(a, b, touch);
  Vec3 next = lambda;
  next[0] = std::max(0.0, lambda[0] + (touch.target(problem.dt) - u[0]) / row.K(0, 0));
  u += row.K.col(0) * (next[0] - lambda[0]);
  const double limit = touch.friction * next[0];
  if (limit > 0 && row.tangent > 0) {
    const double x = next[1] - (row.inverse_tt(0, 0) * u[1] + row.inverse_tt(0, 1) * u[2]);
    const double y = next[2] - (row.inverse_tt(1, 0) * u[1] + row.inverse_tt(1, 1) * u[2]);
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
  applyImpulse(problem, touch, row.axes * change, a, b);
  lambda = next;
  return (row.K * change).cwiseAbs().maxCoeff();
}

void ConstraintResponse::solve(const ResponseProblem& problem, ResponseResult& result) HD_RT {
  const std::size_t count = std::min<std::size_t>(problem.touches.size(), kMaxTouches);
  result.a = problem.free_a;
  result.b = problem.free_b;
  std::array<Vec3, kMaxTouches> lambda;
  for (std::size_t i = 0; i < count; ++i) {
    const Touch& touch = problem.touches[i];
    prepare(problem, touch, row_[i]);
    lambda[i].setZero();
    for (std::uint32_t m = 0; m < remembered_ && touch.key != 0; ++m) {
      if (memory_[m].key != touch.key) continue;
      lambda[i] = row_[i].axes.transpose() * memory_[m].impulse;
      lambda[i][0] = std::max(0.0, lambda[i][0]);
      const double across = std::hypot(lambda[i][1], lambda[i][2]);
      const double limit = touch.friction * lambda[i][0];
      if (across > limit) lambda[i].tail<2>() *= limit / across;
      applyImpulse(problem, touch, row_[i].axes * lambda[i], result.a, result.b);
      break;
    }
  }
  result.rounds = 0;
  double changed = 0;
  do {
    changed = 0;
    for (std::size_t i = 0; i < count; ++i) {
      changed = std::max(changed, relax(problem, problem.touches[i], row_[i], lambda[i], result.a, result.b));
    }
    ++result.rounds;
  } while (changed > kTolerance && result.rounds < kMaxSweeps);

  result.residual = 0;
  result.impulse.fill(Vec3::Zero());
  remembered_ = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Touch& touch = problem.touches[i];
    const double lacking = touch.target(problem.dt) - relativeVelocity(result.a, result.b, touch).dot(touch.n);
    result.residual = std::max(result.residual, lacking);
    result.impulse[i] = row_[i].axes * lambda[i];
    memory_[i] = {touch.key, result.impulse[i]};
  }
}

}  // namespace hapticd
