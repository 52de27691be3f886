#include "drivers/sim/body.h"

#include <algorithm>

namespace hapticd {
namespace {

/** d/dt of the rotation vector e at angular velocity w (inverse of the left Jacobian of SO(3); |e| <= pi). */
Vec3 rotationVectorRate(const Vec3& e, const Vec3& w) HD_RT {
  const double angle = e.norm();
  const double c = angle < 1e-4 ? 1.0 / 12 : (1 - angle / 2 / std::tan(angle / 2)) / (angle * angle);
  const Vec3 turn = e.cross(w);
  return w - turn / 2 + c * e.cross(turn);
}

}  // namespace

PointBody::PointBody(const BodyParameters& body, const Stops& stops, double step_s)
    : body_(body),
      stops_(stops),
      step_s_(step_s),
      linear_(LinearStep::make(body.mass, body.viscous + body.hand_damping, body.hand_stiffness, step_s)),
      stop_scale_(1 / (1 + linear_.vu * (stops.damping + stops.stiffness * step_s / 2))) {}

bool PointBody::atStop() const HD_RT {
  const Vec3 middle = x_ + v_ * (step_s_ / 2);
  return (middle.array() < stops_.lower.array()).any() || (middle.array() > stops_.upper.array()).any();
}

Vec3 PointBody::stopForce(const Vec3& v) const HD_RT {
  Vec3 force = Vec3::Zero();
  const Vec3 middle = x_ + v * (step_s_ / 2);
  for (int i = 0; i < 3; ++i) {
    const double below = stops_.lower[i] - middle[i];
    const double above = middle[i] - stops_.upper[i];
    // A stop pushes, never pulls: damping on the way out only takes away from the spring.
    if (below > 0) force[i] += std::max(0.0, (stops_.stiffness * below - stops_.damping * v[i]) * stop_scale_);
    if (above > 0) force[i] -= std::max(0.0, (stops_.stiffness * above + stops_.damping * v[i]) * stop_scale_);
  }
  return force;
}

void PointBody::step(const Vec3& force, const Vec3& goal, const Vec3& goal_v) HD_RT {
  // Coordinates about the goal keep the spring term small and exact.
  Vec3 offset = x_ - goal;
  Vec3 u = force + body_.hand_damping * goal_v;
  if (atStop()) {
    Vec3 x = offset, v = v_;
    linear_.advance(x, v, u, body_.hand_stiffness, body_.coulomb);
    u += stopForce(v);
  }
  linear_.advance(offset, v_, u, body_.hand_stiffness, body_.coulomb);
  x_ = goal + offset;
}

RotatingBody::RotatingBody(const BodyParameters& body, double step_s)
    : body_(body),
      step_s_(step_s),
      linear_(LinearStep::make(body.mass, body.viscous + body.hand_damping, body.hand_stiffness, step_s)) {}

void RotatingBody::step(const Vec3& torque, const Quat& goal, const Vec3& goal_w) HD_RT {
  Vec3 u = torque + body_.hand_damping * goal_w;
  Vec3 before = Vec3::Zero();
  if (body_.hand_stiffness > 0) {
    before = rotationVector(q_ * goal.conjugate());
    // The rotation vector e does not grow by w but by J^-1(e) w; the spring torque of the difference, at mid-step.
    u -= body_.hand_stiffness * (step_s_ / 2) * (rotationVectorRate(before, w_) - w_);
  }
  Vec3 offset = before;
  linear_.advance(offset, w_, u, body_.hand_stiffness, body_.coulomb);
  q_ = (fromRotationVector(offset - before) * q_).normalized();
}

}  // namespace hapticd
