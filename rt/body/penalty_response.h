/** @file
 * Penalty forces as McNeely, Puterbaugh, Troy (SIGGRAPH 1999) have them: each touch pushes along its normal with
 * stiffness times depth, the depth no more than half a voxel, the sum no stiffer than ten touches together, and touches
 * that are only near brake. Here beside the others because papers compare with it; explicit, without friction.
 */
#pragma once

#include "rt/body/response.h"

namespace hapticd {

struct PenaltyGains {
  double stiffness = 1000;   ///< Of one touch [N/m].
  double braking = 2;        ///< Of one near touch that approaches [N s/m].
  double near = 0.0005;      ///< Gap below which a touch brakes [m].
  double max_depth = 0.001;  ///< What counts of a depth: bounds the force [m].
  double most = 10;          ///< Touches that push fully; more share.
};

class PenaltyResponse final : public Response {
 public:
  explicit PenaltyResponse(const PenaltyGains& gains = {}) noexcept : gains_(gains) {}

  [[nodiscard]] const char* name() const noexcept override { return "penalty"; }
  void solve(const ResponseProblem& problem, ResponseResult& result) HD_RT override;

 private:
  PenaltyGains gains_;
};

}  // namespace hapticd
