/** @file
 * A rigid body: mass, full inertia, pose and motion, and how it moves by itself.
 *
 * Time stepping: a kick (new velocities at the old pose, by whoever solves for forces), then drift(): the centre of
 * mass along a straight line, the rotation by the splitting of Dullweber, Leimkuhler, McLachlan, "Symplectic splitting
 * methods for rigid body molecular dynamics", J. Chem. Phys. 107 (1997): turns about the principal axes, 1 2 3 2 1,
 * each exact. Second order; keeps the angular momentum in the world to rounding. The rotational energy, which it would
 * let swing within a bound, is put right after each step by a turn of the momentum within the body.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/** Of a rigid body, in the frame O of its shape. */
struct MassProperties {
  double mass = 0.1;                         ///< [kg]
  Vec3 com_O = Vec3::Zero();                 ///< Centre of mass C [m].
  Mat3 inertia_O = Mat3::Identity() * 1e-4;  ///< About C, axes of O [kg m^2].

  [[nodiscard]] static MassProperties ofBox(double mass, const Vec3& size);
  [[nodiscard]] static MassProperties ofBall(double mass, double radius);
  /** Solid, along z, of twice that length; the capsule has a half ball at either end besides. */
  [[nodiscard]] static MassProperties ofCylinder(double mass, double radius, double half_length);
  [[nodiscard]] static MassProperties ofCapsule(double mass, double radius, double half_length);
  /** Finite, positive, and moments that a real body can have (each at most the sum of the other two). */
  [[nodiscard]] bool valid() const HD_RT;
};

/** Pose and motion of one body. Constructed by anybody, moved by one real-time thread. */
class RigidBody {
 public:
  /** Needs valid() properties. Finds the principal axes, some microseconds: servo-safe where an order asks for it. */
  explicit RigidBody(const MassProperties& properties) HD_RT;

  [[nodiscard]] double mass() const HD_RT { return mass_; }
  [[nodiscard]] const Vec3& com() const HD_RT { return p_WC_; }  ///< Centre of mass in the world [m].
  [[nodiscard]] const Quat& orientation() const HD_RT { return q_WO_; }
  [[nodiscard]] const Twist& twist() const HD_RT { return V_WC_; }  ///< Of C, in the world.
  /** Of the frame O. */
  [[nodiscard]] Pose pose() const HD_RT { return {p_WC_ - q_WO_ * com_O_, q_WO_}; }
  /** Of O's origin, in the world. */
  [[nodiscard]] Twist originTwist() const HD_RT { return {V_WC_.v - V_WC_.w.cross(q_WO_ * com_O_), V_WC_.w}; }
  [[nodiscard]] Vec3 comInO() const HD_RT { return com_O_; }
  /** About C, in the world [kg m^2]. */
  [[nodiscard]] Mat3 inertia() const HD_RT;
  [[nodiscard]] double kineticEnergy() const HD_RT;
  [[nodiscard]] Vec3 angularMomentum() const HD_RT;  ///< About C, in the world.

  /** Puts O there, at rest. */
  void place(const Pose& X_WO) HD_RT;
  void setTwist(const Twist& V_WC) HD_RT { V_WC_ = V_WC; }
  /** Moves freely for dt, with the momentum, the angular momentum and the energy that it has: never with more. */
  void drift(double dt) HD_RT;

 private:
  double mass_;
  Vec3 com_O_;
  Quat q_OP_;     ///< Principal axes P.
  Vec3 moments_;  ///< About them [kg m^2].
  Vec3 p_WC_ = Vec3::Zero();
  Quat q_WO_ = Quat::Identity();
  Twist V_WC_;
};

}  // namespace hapticd
