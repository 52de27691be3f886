/** @file
 * The moving parts of the simulated device with the hand that holds them: a point mass with soft stops, a rotating
 * inertia, and the same for the gripper.
 */
#pragma once

#include <limits>

#include "drivers/sim/linear_step.h"
#include "rt/base/rotation.h"

namespace hapticd {

/** Mass, friction and hand of one part. SI; for a rotating part read kg m^2, N m s/rad, N m and N m/rad. */
struct BodyParameters {
  double mass = 0.2;          ///< Device and hand together: the hand holds on.
  double viscous = 0;         ///< Of the device.
  double coulomb = 0;         ///< Dry friction of the device; static equals kinetic.
  double hand_stiffness = 0;  ///< Of the grip, toward where the hand wants to be.
  double hand_damping = 0;    ///< Of the grip, relative to the intended motion.
};

/** End stops: a box with a unilateral spring and damper at each face. */
struct Stops {
  Vec3 lower = Vec3::Constant(-std::numeric_limits<double>::infinity());
  Vec3 upper = Vec3::Constant(std::numeric_limits<double>::infinity());
  double stiffness = 0;  ///< [N/m]
  double damping = 0;    ///< [N s/m], while pressed in.
};

/** A point mass moved by force, hand, friction and stops. Real-time safe but for the constructor. */
class PointBody {
 public:
  PointBody(const BodyParameters& body, const Stops& stops, double step_s);

  void place(const Vec3& x, const Vec3& v) HD_RT {
    x_ = x;
    v_ = v;
  }
  /** One step under `force`, the hand aiming at `goal` moving at `goal_v` (their values at the middle of the step). */
  void step(const Vec3& force, const Vec3& goal, const Vec3& goal_v) HD_RT;

  [[nodiscard]] const Vec3& position() const HD_RT { return x_; }
  [[nodiscard]] const Vec3& velocity() const HD_RT { return v_; }

 private:
  [[nodiscard]] bool atStop() const HD_RT;
  /** Over a step at whose end the velocity would be v without it. */
  [[nodiscard]] Vec3 stopForce(const Vec3& v) const HD_RT;

  BodyParameters body_;
  Stops stops_;
  double step_s_;
  LinearStep linear_;
  double stop_scale_;  ///< Makes the stop linearly implicit, so that no stiffness or damping of it is unstable.
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero();
};

/**
 * A rotating part with the same inertia about every axis (so without gyroscopic torque). Exact for turning about a
 * fixed axis, second order in the step otherwise.
 */
class RotatingBody {
 public:
  RotatingBody(const BodyParameters& body, double step_s);

  void place(const Quat& q, const Vec3& w) HD_RT {
    q_ = q;
    w_ = w;
  }
  void step(const Vec3& torque, const Quat& goal, const Vec3& goal_w) HD_RT;

  [[nodiscard]] const Quat& orientation() const HD_RT { return q_; }
  [[nodiscard]] const Vec3& velocity() const HD_RT { return w_; }

 private:
  BodyParameters body_;
  double step_s_;
  LinearStep linear_;
  Quat q_ = Quat::Identity();
  Vec3 w_ = Vec3::Zero();
};

}  // namespace hapticd
