/** @file
 * The thesis's simultaneous impulse response (section 3.3.3): the deepest pair that approaches gets an impulse, the
 * velocities are updated, pairs that now separate drop out; again, until none approaches or the budget is spent.
 *
 * The impulse is eq. (3.7) with the full inertia tensor in place of |r|^2 sin^2(theta) / I, which is the scalar case of
 * n . ((I^-1 (r x n)) x r), and with Coulomb friction. Restitution is Poisson's, by impulse and not by speed: Newton's
 * can create energy when friction turns the slip about (Kane and Levinson, Dynamics, 1985). Each impulse that would
 * still add energy goes without friction, and the restitution is cut to what the compression has lost.
 */
#pragma once

#include "rt/body/response.h"

namespace hapticd {

class ImpulseResponse final : public Response {
 public:
  static constexpr std::uint32_t kMaxRounds = 64;
  static constexpr double kTolerance = 1e-7;  ///< Approach that is let be [m/s].

  [[nodiscard]] const char* name() const noexcept override { return "impulse"; }
  void solve(const ResponseProblem& problem, ResponseResult& result) HD_RT override;

 private:
  void restitute(const ResponseProblem& problem, ResponseResult& result) HD_RT;
};

/**
 * The impulse that brings the relative velocity u to `target` along n, with friction; K is its answer to an impulse.
 * Never adds energy beyond target times its normal part. Zero when u does not fall short of the target.
 */
[[nodiscard]] Vec3 contactImpulse(const Mat3& K, const Vec3& u, const Vec3& n, double target, double friction) HD_RT;

}  // namespace hapticd
