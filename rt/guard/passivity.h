/** @file
 * Passivity observer and controller for a 3-DOF port, in the impedance form (Hannaford and Ryu, IEEE Trans. Robotics
 * and Automation 18(1), 2002, pp. 1-10), with an exact observer and a bounded store.
 *
 * Observer: the device holds the force f it was sent while the hand moves by dx, so the virtual world receives exactly
 * -f.dx (Ryu, Kim, Hannaford 2004): no velocity estimate enters, and jitter of one encoder count cancels instead of
 * adding up. Each Cartesian axis has its own book E_i; the port is active when their sum is negative. One axis alone
 * may be negative in a passive world: on a sphere, energy that goes in along x comes out along y (docs/safety.md).
 *
 * Store: what has been dissipated (damping, friction) is gone and must not pay for later activity. So the sum is kept
 * at or below what the world can really give back plus kMargin (reference energy following: Ryu, Preusche, Hannaford,
 * Hirzinger, IEEE Trans. Control Systems Technology 13(5), 2005).
 *
 * Leak: a stiff wall that buzzes lives on its store for a long time before the sum turns negative. So a second book
 * holds what the store should have gained by the work received and did not: it follows the reference at every tick.
 *
 * Controller: a leak above kLeakZone is repaid by damping along the force; the sum below -kDeadZone by damping on the
 * axes whose book is negative. Never with more than the damping that is left to it, never so that a surface pulls; a
 * hand at rest feels no damping force.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/** Servo thread only. All arguments finite. */
class Passivity {
 public:
  static constexpr double kDeadZone = 0.5e-3;    ///< Debt that is let be [J]: 10 N over an encoder count of 50 um.
  static constexpr double kMargin = 0.5e-3;      ///< Kept above the stored energy [J].
  static constexpr double kLeakZone = 0.05e-3;   ///< Leak that is let be [J]: 10 N over half an encoder count of 10 um.
  static constexpr double kMaxStored = 1.0;      ///< Store when nobody says what the world holds [J].
  static constexpr double kRepay_s = 5e-3;       ///< A debt is repaid over this time [s].
  static constexpr double kRepayLeak_s = 20e-3;  ///< A leak, which comes anew with every tick of a buzz [s].

  explicit Passivity(double max_damping = 0) noexcept : max_damping_(max_damping) {}

  void reset() HD_RT;

  /**
   * Books one tick: `sent` is the passive part of the force that was really sent [N], `moved` the hand's displacement
   * under it [m], `carried` the energy that moving bodies put into the world over it, by axis [J].
   */
  void observe(const Vec3& sent, const Vec3& moved, const Vec3& carried) HD_RT;
  /**
   * Books one tick's leak [J]: growth of the elastic energy that the passive sources hold, less the work received. Lost
   * energy (damping, slip) is negative leak; it pays for at most kMargin.
   */
  void follow(double leaked) HD_RT;
  /** Lowers the store to what the world can give back [J]; negative: unknown, kMaxStored. */
  void limitStore(double stored) HD_RT;

  /**
   * The passive force after the controller. `f` is what is wanted now, `v` the estimated velocity, `v_buzz` that of
   * BuzzVelocity. `carried_power` by axis [W]. Looks one tick ahead, so that the damping comes with the debt and not
   * after it.
   */
  [[nodiscard]] Vec3 control(const Vec3& f, const Vec3& v, const Vec3& v_buzz, const Vec3& carried_power,
                             double dt) HD_RT;

  /** Net energy the world has received [J]: negative means that it has given more than it got. */
  [[nodiscard]] double energy() const HD_RT { return energy_.sum(); }
  /** What has leaked and is not repaid [J]. */
  [[nodiscard]] double leak() const HD_RT { return leak_; }
  [[nodiscard]] const Vec3& byAxis() const HD_RT { return energy_; }
  /** Whether the last control() added damping. */
  [[nodiscard]] bool acting() const HD_RT { return acting_; }
  /** Most that control() adds [N s/m]. */
  void setMaxDamping(double b) HD_RT { max_damping_ = b; }

 private:
  /** Damping, at most `most`, that repays `debt` [J] within `repay_s` where unit damping takes `rate` [m^2/s^2]. */
  [[nodiscard]] static double dampingFor(double debt, double rate, double repay_s, double most) HD_RT;

  double max_damping_;  ///< [N s/m]
  Vec3 energy_ = Vec3::Zero();
  double leak_ = 0;
  bool acting_ = false;
};

}  // namespace hapticd
