#include "rt/body/penalty_response.h"

#include <algorithm>

namespace hapticd {

void PenaltyResponse::solve(const ResponseProblem& problem, ResponseResult& result) HD_RT {
  const std::size_t count = std::min<std::size_t>(problem.touches.size(), kMaxTouches);
  result.a = problem.free_a;
  result.b = problem.free_b;
  result.impulse.fill(Vec3::Zero());
  result.rounds = 1;
  result.residual = 0;
  double pushing = 0;
  for (std::size_t i = 0; i < count; ++i) pushing += problem.touches[i].gap < 0 ? 1 : 0;
  const double share = std::min(1.0, gains_.most / std::max(1.0, pushing));
  for (std::size_t i = 0; i < count; ++i) {
    const Touch& touch = problem.touches[i];
    const double u = relativeVelocity(problem.free_a, problem.free_b, touch).dot(touch.n);
    double force = 0;
    if (touch.gap < 0) {
      force = share * gains_.stiffness * std::min(-touch.gap, gains_.max_depth);
    } else if (touch.gap < gains_.near && u < 0) {
      // Never more than stops the approach: braking is no bounce.
      const double along = touch.n.dot((problem.a.at(touch.r_a) + problem.b.at(touch.r_b)) * touch.n);
      force = std::min(-gains_.braking * u, along > 0 ? -u / (along * problem.dt) : 0.0);
    }
    if (!(force > 0)) continue;
    result.impulse[i] = touch.n * (force * problem.dt);
    applyImpulse(problem, touch, result.impulse[i], result.a, result.b);
  }
  for (const Touch& touch : problem.touches.first(count)) {
    const double u = relativeVelocity(result.a, result.b, touch).dot(touch.n);
    result.residual = std::max(result.residual, touch.target(problem.dt) - u);
  }
}

}  // namespace hapticd
