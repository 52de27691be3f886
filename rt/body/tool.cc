#include "rt/body/tool.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/** Mobility of a body whose grip, r from its centre of mass, is tied by implicit springs: see coupling.h. */
Mobility tied(double mass, const Mat3& inertia, const Vec3& r, double linear, double angular) HD_RT {
  // [ (m + k) 1     -k X            ] [v]   [p]        X = [r]x, k = T^2 stiffness
  // [ k X           I + c 1 - k X X ] [w] = [l]
  const Mat3 X = crossMatrix(r);
  const double a = mass + linear;
  const Mat3 schur = inertia + angular * Mat3::Identity() - linear * (1 - linear / a) * X * X;
  Mobility out;
  out.wl = schur.inverse();
  out.vl = (linear / a) * X * out.wl;
  out.vp = Mat3::Identity() / a - (linear / a) * (linear / a) * X * out.wl * X;
  return out;
}

/**
 * Torque that does the work of f as u, the turn from tool to device, changes: J^-T(side u) f, where du/dt = J^-1 w is
 * the rate of a rotation vector. side 1: on what turns u's head (the device), -1: its tail (the tool). Where f lies
 * along u, as without damping, it is f itself.
 */
Vec3 conjugate(const Vec3& u, const Vec3& f, double side) HD_RT {
  const double angle = u.norm();
  const double c = angle < 1e-4 ? 1.0 / 12 : (1 - angle / 2 / std::tan(angle / 2)) / (angle * angle);
  const Vec3 t = u.cross(f);
  return f + side / 2 * t + c * u.cross(t);
}

double scaleToBound(const Twist& V) HD_RT {
  const double fast = std::max(V.v.norm() / Tool::kMostSpeed, V.w.norm() / Tool::kMostTurn);
  return fast > 1 ? 1 / fast : 1;
}

}  // namespace

Tool::Tool(const ToolSetup& setup) noexcept : setup_(setup), body_(setup.mass) {}

Tool::Stretch Tool::stretch(const RigidBody& body, const Pose& device) const HD_RT {
  return {device.p - body.pose() * setup_.grip_O,
          rotationVector(device.q * setup_.turned * body.orientation().conjugate())};
}

double Tool::energyOf(const RigidBody& body, const Stretch& s, const Vec3& e, const Vec3& e_turn) const HD_RT {
  const CouplingGains& g = setup_.gains;
  return body.kineticEnergy() + SolidStep{g.outer, g.stiffness, 0, 0}.energy(s.d, e) +
         SolidStep{g.angular_outer, g.angular_stiffness, 0, 0}.energy(s.u, e_turn);
}

double Tool::energy() const HD_RT { return energyOf(body_, stretch(body_, device_), e_, e_turn_); }

void Tool::reset(const Pose& device) HD_RT {
  device_ = device;
  const Quat q = (device.q * setup_.turned).normalized();
  body_.place({device.p - q * setup_.grip_O, q});
  e_.setZero();
  e_turn_.setZero();
  reserve_ = 0;
}

void Tool::step(const Pose& device, std::span<Touch> touches, double dt, Response& response, ToolStep& out) HD_RT {
  device_ = device;
  const CouplingGains& g = setup_.gains;
  const SolidStep linear = SolidStep::make(g.outer, g.stiffness, g.damping, dt);
  const SolidStep angular = SolidStep::make(g.angular_outer, g.angular_stiffness, g.angular_damping, dt);
  const Stretch before = stretch(body_, device);
  const double had = energyOf(body_, before, e_, e_turn_);

  // Kick: forces at the end of the step, linear in the new velocities, whose part is in the mobility.
  const Mat3 inertia = body_.inertia();
  const Vec3 r = body_.pose() * setup_.grip_O - body_.com();
  ResponseProblem problem;
  problem.dt = dt;
  problem.a = tied(body_.mass(), inertia, r, dt * dt * linear.stiffness, dt * dt * angular.stiffness);
  const Vec3 pull = linear.force(before.d, linear.deflection(before.d, e_));
  const Vec3 turn = conjugate(before.u, angular.force(before.u, angular.deflection(before.u, e_turn_)), -1);
  const Vec3 p = body_.mass() * body_.twist().v + dt * (pull + setup_.weight);
  const Vec3 l = inertia * body_.twist().w + dt * (r.cross(pull) + turn);
  problem.free_a = problem.a(p, l);
  for (Touch& touch : touches) {
    // Where the detector's speed of recovery would outrun the gap it does not push at all.
    const double over = std::max(0.0, -touch.gap - kSlop);
    touch.separate = std::min(kRecoverSpeed, over / std::max(kRecoverTime, dt));
    if (touch.gap < 0 && over == 0) touch.gap = 0;
  }
  problem.touches = touches;
  ResponseResult result;
  response.solve(problem, result);
  if (!isFinite(result.a.v) || !isFinite(result.a.w)) result.a = Twist{};

  // Drift, clamp. What obstacles and weight put in is known once the motion is.
  Vec3 given = Vec3::Zero();
  Wrench contact;
  out.touching = 0;
  const std::size_t count = std::min<std::size_t>(touches.size(), kMaxTouches);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& j = result.impulse[i];
    if (j.isZero(0)) continue;
    ++out.touching;
    contact.force += j / dt;
    contact.torque += touches[i].r_a.cross(j) / dt;
    given += j.cwiseProduct(touches[i].moving);
  }
  RigidBody moved = body_;
  Stretch after;
  Vec3 e;
  Vec3 e_turn;
  double scale = scaleToBound(result.a);
  double lost = 0;
  for (int tries = 0;; ++tries) {
    moved = body_;
    if (tries == kMostTries) {
      scale = 0;
      given.setZero();
    }
    moved.setTwist({result.a.v * scale, result.a.w * scale});
    moved.drift(dt);
    after = stretch(moved, device);
    e = linear.deflection(after.d, e_);
    e_turn = angular.deflection(after.u, e_turn_);
    const double weight_work = setup_.weight.dot(moved.com() - body_.com());
    lost = had + given.sum() + weight_work - energyOf(moved, after, e, e_turn);
    if (lost >= -reserve_ || tries == kMostTries) break;
    scale *= 0.5;
  }
  body_ = moved;
  e_ = e;
  e_turn_ = e_turn;
  reserve_ = std::clamp(reserve_ + lost, 0.0, kMostReserve);

  out.on_device.force = -linear.force(after.d, e);
  out.on_device.torque = -conjugate(after.u, angular.force(after.u, e_turn), 1);
  out.contact = contact;
  out.obstacle_work = given;
  out.lost = lost;
  out.clamped = scale;
  out.residual = result.residual;
  out.rounds = result.rounds;
}

}  // namespace hapticd
