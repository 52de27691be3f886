/** @file
 * The Falcon's three legs: where the grip is for given angles of the arms, and what torques a force takes.
 *
 * The device's own frame here: x to the operator's right, y up, z from the base toward the operator [m]. Geometry and
 * names after Stamper, A Three Degree of Freedom Parallel Manipulator with Only Translational Degrees of Freedom (PhD
 * thesis, University of Maryland, 1997); sizes as in libnifalcon's FalconGeometry.h. Each leg asks
 *   (hypot(u + c - a cos t1, w - a sin t1) - (d + e))^2 + (v + f)^2 = b^2,
 * a torus and not a sphere, so three of them have no closed solution: Newton's method finds it.
 */
#pragma once

#include <array>
#include <optional>

#include "rt/base/math.h"

namespace hapticd::falcon {

/** Angles of one leg [rad]. */
struct Leg {
  double t1 = 0, t2 = 0, t3 = 0;
};

/** Nothing when a leg does not reach p. */
[[nodiscard]] std::optional<std::array<Leg, 3>> legsAt(const Vec3& p) noexcept;
/** Rows: derivative of each arm's t1 by p [rad/m]. Exact. */
[[nodiscard]] Mat3 jacobian(const std::array<Leg, 3>& legs) noexcept;

/** Solved: where the grip is, and the Jacobian there. */
struct Grip {
  Vec3 p = Vec3::Zero();
  Mat3 dt1_dp = Mat3::Identity();
};
/**
 * The grip for arm angles t1, by Newton's method from `guess`, or else from kMiddle; to 1e-10 m, at most kMostSteps
 * each. Nothing when there is no such place: angles that cannot be together, or not finite. Beyond 5 cm from the axis,
 * where arms are all but stretched, a place may rarely be missed.
 */
[[nodiscard]] std::optional<Grip> gripAt(const Vec3& t1, const Vec3& guess) noexcept;
inline constexpr int kMostSteps = 20;
/** A place in the middle of the workspace, to begin with. */
inline const Vec3 kMiddle{0, 0, 0.125};

/** Angle of an arm by its encoder [rad]: 320 slots, counted fourfold, through capstan and sector; 35 degrees at zero.
 */
[[nodiscard]] double armAngle(double counts) noexcept;
/** [rad] for one count. */
[[nodiscard]] double anglePerCount() noexcept;

/** Torques at the arms [N m] that make the force f [N] at the grip; nothing near a singular place. */
[[nodiscard]] std::optional<Vec3> torquesFor(const Mat3& dt1_dp, const Vec3& f) noexcept;
/** Torques shortened together to at most `limit` each, so that the force keeps its direction. True if they were. */
[[nodiscard]] bool limitTogether(Vec3& torques, double limit) noexcept;

}  // namespace hapticd::falcon
