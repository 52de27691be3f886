/** @file
 * How a fingertip resists being turned on what it presses: the friction moment of its circle of contact, by the four
 * fingerpad models of the thesis (section 2.1.3). A ball of radius R, pressed with P on a flat face, touches in a
 * circle of radius a(P) with pressure p(r); so (eq. 2.1, 2.3) P = 2 pi int p r dr, M = 2 pi mu int p r^2 dr, and the
 * moment is M = mu P arm(P): the arm is what this file gives.
 */
#pragma once

#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/** Which of the models. Numbers are part of recordings. */
enum class PadLaw : std::uint32_t {
  kNone = 0,            ///< A point: no moment.
  kLinear = 1,          ///< The same arm for every force: M = mu_r P, as measured (table 2.3).
  kHertz = 2,           ///< Elastic half-space: M goes as P^(4/3) (eq. 2.13).
  kModifiedHertz = 3,   ///< The same with a fingertip's measured indentation: P^1.1433 (eq. 2.16).
  kViscousSphere = 4,   ///< Springs below a ball that keeps its shape (eq. 2.17 to 2.20).
  kFilledMembrane = 5,  ///< Uniform pressure in the ball's flat (eq. 2.22 to 2.24).
};

/** Constants of the thesis, as printed. */
struct FingertipConstants {
  static constexpr double kStiffness = 190;     ///< b of eq. 2.5 [N/m].
  static constexpr double kHardening = 2100;    ///< m of eq. 2.5 [1/m].
  static constexpr double kPower = 3.4897;      ///< p2 of eq. 2.6.
  static constexpr double kPowerGain = 0.5118;  ///< p1 of eq. 2.6 [N/mm^p2].
  static constexpr double kRadius = 5.8e-3;     ///< R of an index finger's pad [m].
  static constexpr double kArm = 6.2e-3;        ///< mu_r / mu_l of table 2.3: rayon 7.4, suede 6.4, sandpaper 6.2 mm.
  static constexpr double kModulus = 0.25e6;    ///< E* of eq. 2.12 [Pa]; the thesis gives none: soft tissue's.
};

struct Fingerpad {
  PadLaw law = PadLaw::kNone;
  double radius = FingertipConstants::kRadius;  ///< R [m], above 0. Not of kLinear.
  double arm = FingertipConstants::kArm;        ///< Of kLinear [m].
};

/** How far a fingertip yields to a force (eq. 2.5, inverted) [N -> m]. Zero where it is not pressed. Servo-safe. */
[[nodiscard]] double indentationOf(double force) HD_RT;
/** Radius of the circle of contact [m], at most R; 0 of a point or kLinear. Servo-safe. */
[[nodiscard]] double contactRadius(const Fingerpad& pad, double force) HD_RT;
/** M / (mu P) [m], at most R but for kLinear; 0 where it is not pressed. Servo-safe. */
[[nodiscard]] double momentArm(const Fingerpad& pad, double force) HD_RT;

}  // namespace hapticd
