/** @file
 * Contacts as unilateral constraints: 0 <= impulse, perpendicular to 0 <= velocity - target, with Coulomb friction in
 * discs (Moreau's time stepping; Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008), solved
 * by projected Gauss-Seidel sweeps over the touches (Jourdan, Alart, Jean 1998), at most kMaxSweeps of them.
 *
 * With the coupling's stiffness in the mobility this is the quasi-static god-object of Ortega, Redon, Coquillart (2007)
 * when the tool's mass is small against stiffness times dt^2, and a dynamic body when it is not. Starts from the last
 * step's impulses of the same touches, so that what rests is solved in a sweep or two. Where the sweeps do not suffice
 * (one random problem of friction in six) energy may be gained, in 3 of 200 000 such problems and 0.7 % at most; the
 * books of tools and bodies (tool.h, joint_step.h) take it back.
 */
#pragma once

#include "rt/body/constraint_row.h"

namespace hapticd {

class ConstraintResponse final : public Response {
 public:
  static constexpr std::uint32_t kMaxSweeps = 50;
  /** Sweeps end when none of them changes a velocity by more [m/s]: over a minute that is less than a micrometre. */
  static constexpr double kTolerance = 1e-8;

  [[nodiscard]] const char* name() const noexcept override { return "constraint"; }
  void solve(const ResponseProblem& problem, ResponseResult& result) HD_RT override;
  void reset() HD_RT override { remembered_ = 0; }

 private:
  struct Remembered {
    std::uint64_t key = 0;
    Vec3 impulse = Vec3::Zero();
  };

  std::array<ConstraintRow, kMaxTouches> row_;
  std::array<Remembered, kMaxTouches> memory_;
  std::uint32_t remembered_ = 0;
};

}  // namespace hapticd
