// What the point that touches does to the objects that it presses, and what of that is theirs in the guard's books.
#include <algorithm>
#include <array>
#include <cmath>

#include "rt/cycle/cycle.h"

namespace hapticd {

/**
 * What the hand feels of free bodies they feel of it; where several objects hold it, each its own part. `turning` is
 * for that which it touched first; `weight` of all that is rendered is felt.
 *
 * In a narrow wedge a small force has large parts, F / sin(angle), which in one tick would throw a body much harder
 * than the springs could. Together they give no more than those hold: s J . v + s^2 J . M^-1 J / 2 <= stored, s at
 * most 1.
 */
void Cycle::pushBodies(const SurfaceContact& contact, const Vec3& felt, const Vec3& turning, double weight) HD_RT {
  const double dt = period();
  const auto push = [&](std::uint32_t object, const Vec3& force, const Vec3& at) HD_RT {
    const std::uint8_t body = bodies_.find(objectSlot(object));
    if (body == FreeBodies::kNone) return;
    bodies_.push(body, -dt * weight * force, at,
                 object == contact.object ? Vec3(-dt * weight * turning) : Vec3(Vec3::Zero()));
  };
  if (contact.parts == 0) return push(contact.object, felt, contact.point);
  Vec3 rest = felt;
  for (std::uint32_t i = 0; i < contact.parts; ++i) rest -= contact.part[i].force;
  std::array<Vec3, kMaxHolding> force;
  double linear = 0, square = 0;
  for (std::uint32_t i = 0; i < contact.parts; ++i) {
    const ContactPart& part = contact.part[i];
    force[i] = part.force + part.share * rest;
    const std::uint8_t body = bodies_.find(objectSlot(part.object));
    if (body == FreeBodies::kNone || !bodies_.moves(body)) continue;
    const Vec3 impulse = -dt * weight * force[i];
    const Vec3 r = part.point - bodies_.body(body).body.com();
    linear += impulse.dot(bodies_.velocityAt(body, part.point));
    square += 0.5 * impulse.dot(bodies_.mobility(body).at(r) * impulse);
  }
  double scale = 1;
  if (linear + square > contact.stored) {
    const double root = std::sqrt(linear * linear + 4 * square * contact.stored);
    scale = linear > 0 ? 2 * contact.stored / (linear + root) : (root - linear) / (2 * square);
  }
  for (std::uint32_t i = 0; i < contact.parts; ++i)
    push(contact.part[i].object, scale * force[i], contact.part[i].point);
}

/**
 * What clients have put into the springs that hold the hand, which now hold `stored`, by having made their objects
 * stiffer or given them another surface since the last tick [J]: what that adds is theirs, not the wall's. Of several
 * walls each holds k d^2 / 2, as if alone; a relief that is another may have lifted the ground by any height.
 */
double Cycle::changed(DeviceState& device, const SurfaceContact& contact, double stored) const HD_RT {
  std::array<PressedObject, kMaxHolding> now{};
  std::array<double, kMaxHolding> share{};
  double all = 0;
  const std::uint32_t count = contact.parts > 0 ? contact.parts : contact.object != 0 ? 1 : 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const SceneObject* object = scene_.find(contact.parts > 0 ? contact.part[i].object : contact.object);
    if (object == nullptr) continue;
    now[i] = {object->id, object->surface.changes, object->material.stiffness};
    if (!(now[i].stiffness > 0)) continue;  // It holds nothing yet.
    all += share[i] = contact.parts > 0 ? contact.part[i].force.squaredNorm() / now[i].stiffness : 1;
  }
  double put_in = 0;
  bool other_surface = false;
  for (std::uint32_t i = 0; i < count && all > 0; ++i) {
    for (const PressedObject& before : device.pressed) {
      if (before.object == 0 || before.object != now[i].object) continue;
      other_surface = other_surface || before.surface != now[i].surface;
      if (now[i].stiffness > before.stiffness)
        put_in += stored * share[i] / all * (1 - before.stiffness / now[i].stiffness);
      break;
    }
  }
  if (other_surface) put_in = std::max(0.0, stored - device.pressed_stored);
  device.pressed = now;
  device.pressed_stored = stored;
  return put_in;
}

/** What a fingertip adds to the contact of a point; a point is as viscous along the surface as the material across. */
FingerForces Cycle::touchSoftly(std::uint32_t d, DeviceOutput& out) HD_RT {
  const SceneObject* const object = scene_.find(out.contact.object);
  FingerMotion motion{out.velocity, object != nullptr ? object->V_WO.w : Vec3::Zero()};
  motion.fingers = static_cast<int>(config_.device_count);
  const std::uint8_t k = object != nullptr ? bodies_.find(objectSlot(object->id)) : FreeBodies::kNone;
  if (k != FreeBodies::kNone && bodies_.moves(k)) {
    motion.r = out.contact.point - bodies_.body(k).body.com();
    motion.body = bodies_.mobility(k);
  }
  FingerForces pad;
  if (SoftFinger& finger = devices_[d].finger; finger.soft()) {
    pad = finger.settle(scene_, out.contact, motion, period());
  } else {
    const PadForce viscous = padForce(out.contact, motion, out.contact.damping_gain, period());
    pad.force = viscous.force;
    pad.damping = viscous.damping;
  }
  out.contact.force += pad.force;
  return pad;
}

}  // namespace hapticd
