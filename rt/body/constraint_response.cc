#include "rt/body/constraint_response.h"

#include <algorithm>

namespace hapticd {

void ConstraintResponse::solve(const ResponseProblem& problem, ResponseResult& result) HD_RT {
  const std::size_t count = std::min<std::size_t>(problem.touches.size(), kMaxTouches);
  result.a = problem.free_a;
  result.b = problem.free_b;
  std::array<Vec3, kMaxTouches> lambda;
  for (std::size_t i = 0; i < count; ++i) {
    const Touch& touch = problem.touches[i];
    prepareRow(problem.a, problem.b, touch, problem.dt, row_[i]);
    lambda[i].setZero();
    for (std::uint32_t m = 0; m < remembered_ && touch.key != 0; ++m) {
      if (memory_[m].key != touch.key) continue;
      lambda[i] = startRow(row_[i], touch, memory_[m].impulse);
      applyPair(problem.a, problem.b, touch, row_[i].axes * lambda[i], result.a, result.b);
      break;
    }
  }
  result.rounds = 0;
  double changed = 0;
  do {
    changed = 0;
    for (std::size_t i = 0; i < count; ++i) {
      changed =
          std::max(changed, relaxRow(problem.a, problem.b, problem.touches[i], row_[i], lambda[i], result.a, result.b));
    }
    ++result.rounds;
  } while (changed > kTolerance && result.rounds < kMaxSweeps);

  result.residual = 0;
  result.impulse.fill(Vec3::Zero());
  remembered_ = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Touch& touch = problem.touches[i];
    result.residual = std::max(result.residual, lacking(row_[i], touch, lambda[i], result.a, result.b));
    result.impulse[i] = row_[i].axes * lambda[i];
    memory_[i] = {touch.key, result.impulse[i]};
  }
}

}  // namespace hapticd
