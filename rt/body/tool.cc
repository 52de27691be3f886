#include "rt/body/tool.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace

double scaleToBound(const Twist& V) HD_RT {
  const double fast = std::max(V.v.norm() / Tool::kMostSpeed, V.w.norm() / Tool::kMostTurn);
  return fast > 1 ? 1 / fast : 1;
}

void settleTouches(std::span<Touch> touches, double dt) HD_RT {
  for (Touch& touch : touches) {
    if (touch.give > 0) continue;
    // Where the detector's speed of recovery would outrun the gap it does not push at all.
    const double over = std::max(0.0, -touch.gap - Tool::kSlop);
    touch.separate = std::min(Tool::kRecoverSpeed, over / std::max(Tool::kRecoverTime, dt));
    if (touch.gap < 0 && over == 0) touch.gap = 0;
  }
}

double heldBy(const Touch& touch, double opened) HD_RT {
  const double depth = std::max(0.0, -touch.gap - opened);
  return touch.give > 0 ? 0.5 * depth * depth / touch.give : 0;
}

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

void Tool::kick(const Pose& device, double dt, Kick& out) HD_RT {
  const Vec3 last_u = stretch(body_, device_).u;
  device_ = device;
  const CouplingGains& g = setup_.gains;
  out.device = device;
  out.dt = dt;
  out.linear = SolidStep::make(g.outer, g.stiffness, g.damping, dt);
  out.angular = SolidStep::make(g.angular_outer, g.angular_stiffness, g.angular_damping, dt);
  const Stretch before = stretch(body_, device);
  if ((before.u - last_u).norm() > std::numbers::pi) {
    // The hand has turned past half a turn, and the short way back is the other one now. What the coupling holds is
    // mirrored with it: else its inner part would stand against it, with joules that nobody gave.
    const Vec3 axis = before.u.normalized();
    e_turn_ -= 2 * axis.dot(e_turn_) * axis;
  }
  out.had = energyOf(body_, before, e_, e_turn_);

  // Forces at the end of the step, linear in the new velocities, whose part is in the mobility.
  const Mat3 inertia = body_.inertia();
  const Vec3 r = body_.pose() * setup_.grip_O - body_.com();
  out.mobility = tied(body_.mass(), inertia, r, dt * dt * out.linear.stiffness, dt * dt * out.angular.stiffness);
  const Vec3 pull = out.linear.force(before.d, out.linear.deflection(before.d, e_));
  const Vec3 turn = conjugate(before.u, out.angular.force(before.u, out.angular.deflection(before.u, e_turn_)), -1);
  const Vec3 p = body_.mass() * body_.twist().v + dt * (pull + setup_.weight);
  const Vec3 l = inertia * body_.twist().w + dt * (r.cross(pull) + turn);
  out.free = out.mobility(p, l);
}

void Tool::move(const Kick& kick, const Twist& V, Move& out) const HD_RT {
  out.body = body_;
  out.body.setTwist(V);
  out.body.drift(kick.dt);
  const Stretch after = stretch(out.body, kick.device);
  out.d = after.d;
  out.u = after.u;
  out.e = kick.linear.deflection(after.d, e_);
  out.e_turn = kick.angular.deflection(after.u, e_turn_);
  const double weight_work = setup_.weight.dot(out.body.com() - body_.com());
  out.gained = energyOf(out.body, after, out.e, out.e_turn) - weight_work - kick.had;
}

void Tool::accept(const Kick& kick, const Move& move, double reserve, ToolStep& out) HD_RT {
  body_ = move.body;
  e_ = move.e;
  e_turn_ = move.e_turn;
  reserve_ = reserve;
  out.on_device.force = -kick.linear.force(move.d, move.e);
  out.on_device.torque = -conjugate(move.u, kick.angular.force(move.u, move.e_turn), 1);
}

void Tool::step(const Pose& device, std::span<Touch> touches, double dt, Response& response, ToolStep& out) HD_RT {
  Kick kicked;
  kick(device, dt, kicked);
  settleTouches(touches, dt);
  ResponseProblem problem;
  problem.dt = dt;
  problem.a = kicked.mobility;
  problem.free_a = kicked.free;
  problem.touches = touches;
  ResponseResult result;
  response.solve(problem, result);
  if (!isFinite(result.a.v) || !isFinite(result.a.w)) result.a = Twist{};

  Vec3 given = Vec3::Zero();
  double held = 0;
  out.contact = Wrench{};
  out.touching = 0;
  const std::size_t count = std::min<std::size_t>(touches.size(), kMaxTouches);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& j = result.impulse[i];
    held += heldBy(touches[i], dt * relativeVelocity(result.a, result.b, touches[i]).dot(touches[i].n));
    if (j.isZero(0)) continue;
    ++out.touching;
    out.contact.force += j / dt;
    out.contact.torque += touches[i].r_a.cross(j) / dt;
    given += j.cwiseProduct(touches[i].moving);
  }
  // Drift, clamp. What obstacles and weight put in is known once the motion is.
  Move moved(body_);
  double scale = scaleToBound(result.a);
  double lost = 0;
  for (int tries = 0;; ++tries) {
    if (tries == kMostTries) {
      scale = 0;
      given.setZero();
    }
    move(kicked, {result.a.v * scale, result.a.w * scale}, moved);
    lost = given.sum() - moved.gained;
    if (lost >= -reserve_ || tries == kMostTries) break;
    scale *= 0.5;
  }
  accept(kicked, moved, std::clamp(reserve_ + lost, 0.0, kMostReserve + held), out);
  out.obstacle_work = given;
  out.lost = lost;
  out.clamped = scale;
  out.residual = result.residual;
  out.rounds = result.rounds;
}

}  // namespace hapticd
