#include "rt/body/impulse_response.h"

#include <algorithm>

namespace hapticd {
namespace {

Mat3 answer(const ResponseProblem& problem, const Touch& touch) HD_RT {
  return problem.a.at(touch.r_a) + problem.b.at(touch.r_b);
}

}  // namespace

Vec3 contactImpulse(const Mat3& K, const Vec3& u, const Vec3& n, double target, double friction) HD_RT {
  const double lacking = target - u.dot(n);
  const double along = n.dot(K * n);
  if (!(lacking > 0) || !(along > 0)) return Vec3::Zero();
  Vec3 smooth = n * (lacking / along);
  if (!(friction > 0)) return smooth;

  Vec3 j = K.inverse() * (n * target - u);  // the point sticks
  double normal = j.dot(n);
  const Vec3 across = j - normal * n;
  if (!(normal > 0) || across.norm() > friction * normal) {
    const Vec3 slip = u - u.dot(n) * n;
    const double speed = slip.norm();
    if (!(speed > 0)) return smooth;
    const Vec3 d = n - (friction / speed) * slip;
    const double reached = n.dot(K * d);
    if (!(reached > 0.05 * along)) return smooth;  // it would jam: friction alone turns the body into the surface
    normal = lacking / reached;
    j = normal * d;
  }
  const double gained = j.dot(u + 0.5 * (K * j));
  return gained <= std::max(0.0, normal * target) ? j : smooth;
}

void ImpulseResponse::solve(const ResponseProblem& problem, ResponseResult& result) HD_RT {
  const std::span<const Touch> touches =
      problem.touches.first(std::min<std::size_t>(problem.touches.size(), kMaxTouches));
  result.a = problem.free_a;
  result.b = problem.free_b;
  result.impulse.fill(Vec3::Zero());
  result.rounds = 0;
  result.residual = 0;
  while (true) {
    const Touch* deepest = nullptr;
    double worst = 0;
    for (const Touch& touch : touches) {
      const double lacking = touch.target(problem.dt) - relativeVelocity(result.a, result.b, touch).dot(touch.n);
      worst = std::max(worst, lacking);
      if (lacking > kTolerance && (deepest == nullptr || touch.gap < deepest->gap)) deepest = &touch;
    }
    result.residual = worst;
    if (deepest == nullptr || result.rounds == kMaxRounds) break;
    const Touch& touch = *deepest;
    const Vec3 u = relativeVelocity(result.a, result.b, touch);
    const Vec3 j = contactImpulse(answer(problem, touch), u, touch.n, touch.target(problem.dt), touch.friction);
    applyImpulse(problem, touch, j, result.a, result.b);
    result.impulse[static_cast<std::size_t>(&touch - touches.data())] += j;
    ++result.rounds;
  }
  restitute(problem, result);
}

void ImpulseResponse::restitute(const ResponseProblem& problem, ResponseResult& result) HD_RT {
  // Poisson: the impulse of restitution is e times that of compression, along the normal. Energy over it is
  // quadratic in how much of it is applied: E(s) = lost + s linear + s^2 square.
  std::array<Vec3, kMaxTouches> back;
  Twist a = result.a;
  Twist b = result.b;
  double lost = 0;
  double linear = 0;
  bool any = false;
  const std::size_t count = std::min<std::size_t>(problem.touches.size(), kMaxTouches);
  for (std::size_t i = 0; i < count; ++i) {
    const Touch& touch = problem.touches[i];
    const Vec3& j = result.impulse[i];
    const Vec3 before = relativeVelocity(problem.free_a, problem.free_b, touch);
    const Vec3 after = relativeVelocity(result.a, result.b, touch);
    const bool hit = touch.gap <= 0 && before.dot(touch.n) < 0;
    back[i] = hit ? Vec3(touch.n * (touch.restitution * j.dot(touch.n))) : Vec3(Vec3::Zero());
    lost += 0.5 * j.dot(before + after);
    linear += back[i].dot(after);
    if (back[i].isZero(0)) continue;
    any = true;
    applyImpulse(problem, touch, back[i], a, b);
  }
  if (!any || !(lost < 0)) return;
  double square = 0;
  for (std::size_t i = 0; i < count; ++i) {
    square += 0.5 * back[i].dot(relativeVelocity(a, b, problem.touches[i]) -
                                relativeVelocity(result.a, result.b, problem.touches[i]));
  }
  double share = 1;
  if (lost + linear + square > 0) {
    share = (std::sqrt(linear * linear - 4 * square * lost) - linear) / (2 * square);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (back[i].isZero(0)) continue;
    applyImpulse(problem, problem.touches[i], share * back[i], result.a, result.b);
    result.impulse[i] += share * back[i];
  }
}

}  // namespace hapticd
