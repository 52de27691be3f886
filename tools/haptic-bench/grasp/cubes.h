/** @file
 * Pick and place of 27 cubes (thesis section 2.2.2): with how much force is each held? A simulated person, as the
 * thesis's subjects, first lets the cube fall by opening the fingers ever further, and so learns where it falls; then
 * takes it again, and holds it for ten seconds as loosely as it can be held: a step tighter where it slides.
 */
#pragma once

#include <vector>

#include "tools/haptic-bench/grasp/rig.h"

namespace haptic_bench::grasp {

/** One person's turn with a cube. */
struct Hold {
  double fell = 0;  ///< Each finger's force when it fell [N],
  double held = 0;  ///< and on average over the ten seconds: the grip force [N].
};

struct Cube {
  double mass;       ///< [kg]
  double friction;   ///< Static; that of sliding goes with it.
  double stiffness;  ///< [N/m]
  double slips = 0;  ///< Closed form: m g / (2 mu_s) [N].
  std::vector<Hold> holds{};

  [[nodiscard]] Hold mean() const;
  /** The safety margin of one, as a part of the force at which it slips. */
  [[nodiscard]] double margin() const { return mean().held / slips - 1; }
};

/** How the grip force goes with each: Spearman's rank correlation over all holds. */
struct Correlations {
  double friction = 0, mass = 0, stiffness = 0;
};
/** Table 2.2. */
inline constexpr Correlations kThesis{-0.346, 0.391, 0.333};

/** All combinations; each of `persons` holds each cube `turns` times. */
[[nodiscard]] std::vector<Cube> holdCubes(int persons, int turns, double unsteady);
[[nodiscard]] Correlations correlate(const std::vector<Cube>& cubes);

/** Spearman's rho: Pearson's of the ranks, those of equals averaged. Of as many of each; nan where all are equal. */
[[nodiscard]] double spearman(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace haptic_bench::grasp
