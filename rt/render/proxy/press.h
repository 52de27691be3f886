/** @file
 * What several surfaces press with when they hold a hand together, each as stiff as its own material makes it.
 */
#pragma once

#include <span>

#include "rt/base/math.h"

namespace hapticd {

/** One of the surfaces that hold a hand. */
struct Pressing {
  Vec3 normal = Vec3::Zero();  ///< Outward, unit.
  double push = 0;             ///< Not negative; `up` is the sum of push * normal [m].
  double stiffness = 0;        ///< [N/m].
};

/**
 * The force on a hand that is `up` (from the hand to where all surfaces let it be) too deep [N]. Walls at right angles
 * press each with k depth, as if alone; surfaces that are equally stiff together with k up; and however they stand they
 * are together no stiffer than the stiffest of them nor softer than the softest. A surface that comes in or goes
 * presses with nothing, so no force jumps.
 *
 * For one order of the surfaces: the first presses with k (n . up) n, the next ones with what is left of `up` across
 * n, along their normals across n. That is K up with K symmetric and its eigenvalues the stiffnesses. The mean of all
 * orders, the first counted as it pushes, then the second of those left, is within the same bounds, and where one
 * alone pushes it is the first. What of `up` is no sum of their normals, as while a proxy is still on its way, the last
 * one presses with. Servo-safe; at most kMaxPressing surfaces, six orders.
 */
[[nodiscard]] Vec3 press(std::span<const Pressing> surfaces, const Vec3& up) HD_RT;

inline constexpr int kMaxPressing = 3;

}  // namespace hapticd
