/** @file
 * The virtual coupling between the hand and a tool (thesis eq. 1.1 and 1.2, corrected), and gains that keep it passive.
 *
 * Corrections: the coupling point moves with v + w x (R x_c), not v + w x x_c; the device gets the opposite force, and
 * of the torque the springs' part alone, without (R x_c) x F.
 *
 * The damper does not touch the hand. (1.1) puts it between the hand and the tool; but a device that is told a force
 * once a tick then needs b > K T / 2 + b_c of its own (Colgate and Schenkel 1994), and what it needs for b_c it lacks
 * for K. So here the hand pulls at an outer spring k_o, and behind it are the spring k_c and the damper b_c of (1.1)
 * in parallel, with nothing between that has mass (a standard linear solid):
 *
 *     hand o--- k_o ---o--- k_c || b_c ---o tool        F = k_o (d - e) = k_c e + b_c e',  d: hand from tool
 *
 * In time, e is implicit: with b = b_c / T, F = k (d - g e_before), k = k_o (k_c + b) / (k_o + k_c + b), g = b / (k_c +
 * b).
 *
 * Why it is passive. Between two ticks the force stands still while the hand moves by dx. It gives F . dx; the outer
 * spring, with e and the tool as they were, takes F . dx + k_o dx^2 / 2. All that follows in the tick (e, tool,
 * contacts) is backward Euler or clamped (tool.h), and so only loses energy at a hand that stands still. The world has
 * therefore given away at most k_o dx^2 / 2 a tick, which a device with viscous friction b_d takes in, b_d dx^2 / T,
 * when k_o <= 2 b_d / T; with a force that acts tau late, F . dx misses up to k_o dx^2 tau / T more, hence
 *
 *     k_o <= b_d / (T / 2 + tau),   whatever the tool's mass, b_c, and whatever it touches.
 *
 * In rotation so where the tool is near: across its axis u grows by (|u| / 2) / sin(|u| / 2) for each radian of the
 * hand's, and half a turn away the leak is up to pi^2 / 4 as much.
 *
 * The tool's mass sets b_c: the solid damps best where the tool swings.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/device.h"

namespace hapticd {

/** Of one coupling. All >= 0. */
struct CouplingGains {
  double outer = 0;          ///< k_o: what is felt at once [N/m].
  double stiffness = 0;      ///< k_c [N/m]; what is felt in the end is k_o k_c / (k_o + k_c).
  double damping = 0;        ///< b_c [N s/m]
  double angular_outer = 0;  ///< The same for rotation [N m/rad].
  double angular_stiffness = 0;
  double angular_damping = 0;  ///< [N m s/rad]
};

/** What the gains are chosen from. */
struct CouplingNeeds {
  double mass = 0.1;      ///< Of the tool [kg].
  double inertia = 1e-4;  ///< Its mean moment [kg m^2].
  double dt = 1e-3;       ///< Of the servo [s].
  double wanted = 0;      ///< Stiffness in the end that the user asks for [N/m]; 0: what is passive.
};

/**
 * Gains for a device: passive by the condition above where the device knows its viscous friction, else half the
 * stiffness that it is told to bear. `wanted` may go up to that (DeviceInfo::max_stiffness, for the outer spring),
 * beyond what is provably passive: then the guard's observer and controller stand between.
 */
[[nodiscard]] CouplingGains chooseGains(const DeviceInfo& device, const CouplingNeeds& needs) noexcept;

/** One half of a coupling over one step, in three axes: translation or rotation. */
struct SolidStep {
  double outer = 0, inner = 0;  ///< k_o, k_c
  double damping = 0;           ///< b_c / T
  double stiffness = 0;         ///< k: d F / d d within the step.

  [[nodiscard]] static SolidStep make(double outer, double inner, double damping, double dt) HD_RT {
    SolidStep out{outer, inner, damping / dt, 0};
    if (out.sum() > 0) out.stiffness = outer * (inner + out.damping) / out.sum();
    return out;
  }
  [[nodiscard]] double sum() const HD_RT { return outer + inner + damping; }
  /** Deflection e of the inner part after the step in which d became `d`. */
  [[nodiscard]] Vec3 deflection(const Vec3& d, const Vec3& e_before) const HD_RT {
    return sum() > 0 ? Vec3((outer * d + damping * e_before) / sum()) : Vec3(Vec3::Zero());
  }
  [[nodiscard]] Vec3 force(const Vec3& d, const Vec3& e) const HD_RT { return outer * (d - e); }
  [[nodiscard]] double energy(const Vec3& d, const Vec3& e) const HD_RT {
    return 0.5 * (outer * (d - e).squaredNorm() + inner * e.squaredNorm());
  }
};

}  // namespace hapticd
