#include "rt/finger/soft_finger.h"

#include <algorithm>
#include <cmath>

#include "rt/base/rotation.h"

namespace hapticd {
namespace {

bool upTo(double x, double most) HD_RT { return x >= 0 && x <= most; }

/** By how much `to` is turned from `from` about n [rad]. */
double turnAbout(const Vec3& n, const Quat& from, const Quat& to) HD_RT {
  return rotationVector(to * from.conjugate()).dot(n);
}

/** What friction is of [N]. */
double pressOf(const SurfaceContact& contact) HD_RT {
  return std::max(0.0, contact.stiffness * contact.depth + std::min(0.0, contact.damping));
}

/** Of a coefficient what a load across leaves for the other: sqrt(1 - share^2), the ellipse of eq. 2.48. */
double left(double share) HD_RT { return std::sqrt(std::max(0.0, 1 - share * share)); }

}  // namespace

bool SoftFinger::valid(const SetFinger& order) HD_RT {
  if (order.law == static_cast<std::uint32_t>(PadLaw::kNone)) return true;
  return order.law <= static_cast<std::uint32_t>(PadLaw::kFilledMembrane) && order.radius > 0 &&
         upTo(order.radius, kMostArm) && upTo(order.arm, kMostArm) && order.stiffness > 0 &&
         upTo(order.stiffness, kMostStiffness) && upTo(order.damping, kMostDamping) && upTo(order.cue, kMostCue);
}

void SoftFinger::set(const SetFinger& order) HD_RT {
  order_ = order;
  pad_ = {static_cast<PadLaw>(order.law), order.radius, order.arm};
  coupled_ = (order.flags & kFingerUncoupled) == 0;
  if (!soft()) reset();
}

void SoftFinger::reset() HD_RT {
  object_ = 0;
  twist_ = arm_ = phase_ = 0;
  slips_ = false;
}

PadForce padForce(const SurfaceContact& contact, const FingerMotion& motion, double damping, double dt,
                  double share) HD_RT {
  const Vec3 v = contact.at_hip - motion.hand.v, v_across = v - v.dot(contact.normal) * contact.normal;
  const double speed = v_across.norm();
  if (contact.slip || !(speed > 0) || motion.body.vp.isZero(0)) return {};
  const Vec3 t = v_across / speed;
  const double w_along = motion.fingers * dt * t.dot(motion.body.at(motion.r) * t);
  const double b = std::min({damping, motion.most_damping, 1 / w_along});
  const Vec3 elastic = contact.stiffness * (contact.pull - contact.pull.dot(contact.normal) * contact.normal);
  Vec3 all = elastic + b * v_across;
  const double most = share * contact.friction.still * pressOf(contact);
  if (all.norm() > most) all = most > elastic.norm() ? Vec3(all * (most / all.norm())) : elastic;
  return {all - elastic, b};
}

TwistLoad SoftFinger::turn(const Scene& scene, const Quat& q_hand) HD_RT {
  q_now_ = q_hand;
  const SceneObject* const object = scene.find(object_);
  if (object == nullptr) return {};
  twist_ += turnAbout(normal_, q_object_, object->X_WO.q) - turnAbout(normal_, q_hand_, q_now_);
  return coupled_ && arm_ > 0 ? TwistLoad{stiffness_ * std::abs(twist_), arm_} : TwistLoad{};
}

FingerForces SoftFinger::settle(const Scene& scene, const SurfaceContact& contact, const FingerMotion& motion,
                                double dt) HD_RT {
  FingerForces out;
  const SceneObject* const object = scene.find(contact.object);
  if (object == nullptr || !(contact.stiffness > 0)) {
    reset();
    return out;
  }
  object_ = contact.object;
  q_object_ = object->X_WO.q;
  q_hand_ = q_now_;
  normal_ = contact.normal;

  // The normal force, and the share of friction that sliding forces take already: x of eq. 2.48, for mu_s and mu_d.
  const double pressed = pressOf(contact);
  const Vec3 lag = contact.pull - contact.pull.dot(normal_) * normal_;
  const double across = contact.stiffness * lag.norm();
  const Friction& mu = contact.friction;
  arm_ = momentArm(pad_, pressed);
  const auto mostMoment = [&](double coefficient, double beside) HD_RT {
    const double bears = coefficient * pressed;
    return bears > 0 ? arm_ * bears * (coupled_ ? left(beside / bears) : 1) : 0.0;
  };
  // Spring and viscosity of the twist stop a light body within a tick at the most, together with the other fingers that
  // may hold it: what is beyond would throw it back.
  const double w = motion.fingers * dt * normal_.dot(motion.body.wl * normal_);
  const double k = w > 0 ? std::min(order_.stiffness, 1 / (w * (dt + kTwistRetardation))) : order_.stiffness;
  stiffness_ = k;
  const double still = mostMoment(mu.still, across), sliding = mostMoment(mu.sliding, across);
  const double moment = k * twist_;
  slips_ = slips_ || (coupled_ && contact.slip) ? std::abs(moment) > sliding : std::abs(moment) > still;
  if (slips_) twist_ = std::copysign(sliding / k, moment);
  out.moment = k * twist_;

  // While it sticks the pad is viscous too, but spring and viscosity together never exceed friction: what both springs
  // leave of the ellipse is the force's, and what that leaves the moment's.
  const double w_relative = (motion.w_object - motion.hand.w).dot(normal_);
  const Vec3 v = contact.at_hip - motion.hand.v, v_across = v - v.dot(normal_) * normal_;
  const double speed = v_across.norm(), bears = arm_ * mu.still * pressed;
  const double share = coupled_ && bears > 0 ? left(out.moment / bears) : 1;
  const PadForce pad = padForce(contact, motion, order_.damping, dt, share);
  if (!slips_) {
    const double most = mostMoment(mu.still, (contact.stiffness * lag + pad.force).norm());
    out.moment = std::clamp(out.moment + k * kTwistRetardation * w_relative, -most, most);
  }
  out.force = pad.force;
  out.damping = pad.damping;
  const double slide = contact.slip ? speed : 0, twirl = slips_ ? arm_ * w_relative : 0;
  out.cue = cueOf(std::hypot(slide, twirl), dt);
  return out;
}

/** Of slip at that speed: its strength and its pitch grow with it (thesis section 2.4). */
Vec3 SoftFinger::cueOf(double speed, double dt) HD_RT {
  if (!(order_.cue > 0 && speed > 0)) return Vec3::Zero();
  constexpr double kTwoPi = 6.283185307179586;
  phase_ = std::remainder(phase_ + kTwoPi * dt * std::min(speed / kCueLength, kMostCueFrequency), kTwoPi);
  return std::min(order_.cue * speed, kMostCueForce) * std::sin(phase_) * Vec3::UnitZ();
}

}  // namespace hapticd
