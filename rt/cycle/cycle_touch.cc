// What the point that touches does to the objects that it presses, and what of that is theirs in the guard's books.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rt/cycle/cycle.h"
#include "rt/guard/damping_left.h"

namespace hapticd {
namespace {

constexpr double kAnyEnergy = std::numeric_limits<double>::infinity();

}  // namespace

/** Whether the parts of a contact are much larger than their sum: those of faces that meet at less than 60 degrees. */
bool Cycle::isNarrow(const SurfaceContact& contact) HD_RT {
  constexpr double kNarrow = 2;
  double pressing = 0;
  Vec3 sum = Vec3::Zero();
  for (std::uint32_t i = 0; i < contact.parts; ++i) {
    pressing += contact.part[i].force.norm();
    sum += contact.part[i].force;
  }
  return pressing > kNarrow * sum.norm();
}

/**
 * What the hand feels of free bodies they feel of it; where several objects hold it, each its own part. `turning` is
 * for that which it touched first; `weight` of all that is rendered is felt.
 *
 * In a narrow wedge a small force has large parts, F / sin(angle), and a proxy between two that close on it goes far:
 * a body would be thrown much harder than it came. So from a narrow wedge on, until all is paid for that the springs
 * hold, it is given no more than was put into them (lent()): s J . v + s^2 J . M^-1 J / 2 <= lent, s at most 1.
 */
void Cycle::pushBodies(DeviceState& device, const Vec3& hand, const SurfaceContact& contact, const Vec3& felt,
                       const Vec3& turning, double weight) HD_RT {
  Lending& lending = device.lending;
  const std::uint32_t count = std::max(contact.parts, 1U);
  bool touched = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t object = contact.parts > 0 ? contact.part[i].object : contact.object;
    touched = touched || bodies_.find(objectSlot(object)) != FreeBodies::kNone;
  }
  if (!touched) {
    lending.begin(contact.stored, felt);
    return;
  }
  std::array<ContactPart, kMaxHolding> part = contact.part;
  Vec3 rest = felt;
  for (std::uint32_t i = 0; i < contact.parts; ++i) rest -= part[i].force;
  for (std::uint32_t i = 0; i < contact.parts; ++i) part[i].force += part[i].share * rest;
  if (contact.parts == 0) part[0] = {contact.object, contact.point, felt, 1};

  const Vec3 way = hand - lending.hand;
  const double dt = period(), by_hand = -std::max(felt.dot(way), 0.5 * (lending.felt + felt).dot(way));
  double linear = 0, square = 0, lent = this->lent(lending) + by_hand;
  lending.count = count;
  for (std::uint32_t i = 0; i < count; ++i) {
    Given& given = lending.given[i];
    given = {part[i].object, bodies_.find(objectSlot(part[i].object)), part[i].point, -dt * weight * part[i].force};
    if (given.body == FreeBodies::kNone) continue;
    given.at -= bodies_.body(given.body).body.com();
    given.velocity = bodies_.velocityBefore(given.body, given.at);
    if (!bodies_.moves(given.body)) continue;
    linear += given.impulse.dot(given.velocity);
    square += 0.5 * given.impulse.dot(bodies_.mobility(given.body).at(given.at) * given.impulse);
    if (bodies_.wasPut(given.body)) lent = contact.stored;
  }
  lending.felt = felt;
  // More than the springs hold is what dampers take from the hand now, and, half-way out of an elastic bounce, up to
  // J . v: a step's force is that of its place, and its way that of the velocity which this leaves.
  lending.energy = std::clamp(lent, 0.0, contact.stored + std::max(0.0, linear) + std::max(0.0, by_hand));
  lending.bound = isNarrow(contact) || (lending.bound && lending.energy < contact.stored);
  const double most = lending.bound ? lending.energy : contact.parts > 0 ? contact.stored : kAnyEnergy;
  double scale = 1;
  if (linear + square > most) {
    const double root = std::sqrt(linear * linear + 4 * square * most);
    scale = linear > 0 ? 2 * most / (linear + root) : (root - linear) / (2 * square);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    Given& given = lending.given[i];
    if (given.body == FreeBodies::kNone) continue;
    given.impulse *= bodies_.moves(given.body) ? scale : 0;
    bodies_.push(given.body, given.impulse, part[i].point,
                 given.object == contact.object ? Vec3(-dt * weight * scale * turning) : Vec3(Vec3::Zero()));
  }
}

/**
 * What springs have still to lend after a tick [J], in which clients' objects worked on them, and bodies: by the
 * impulse J that it got each lost J . (v + v') / 2. Both velocities are those before any hand pushes: so what several
 * hands gave adds up, in whatever order, and one at rest between them lost nothing.
 */
double Cycle::lent(const Lending& last) const HD_RT {
  double lent = last.energy;
  for (std::uint32_t i = 0; i < last.count; ++i) {
    const Given& given = last.given[i];
    const SceneObject* const object = scene_.find(given.object);
    if (object == nullptr) continue;
    const std::uint8_t body = bodies_.find(objectSlot(given.object));
    if (body != given.body) continue;
    if (body == FreeBodies::kNone) {
      lent -= given.impulse.dot(object->velocityAt(given.at));
    } else {
      lent -= 0.5 * given.impulse.dot(given.velocity + bodies_.velocityBefore(body, given.at));
    }
  }
  return lent;
}

/**
 * What clients have put into the springs that hold the hand, which now hold `stored`, by having made their objects
 * stiffer or given them another surface or shape since the last tick [J]: what that adds is theirs, not the wall's. Of
 * several walls each holds k d^2 / 2, as if alone; a relief or shape that is another may have lifted the ground by any
 * height.
 */
double Cycle::changed(DeviceState& device, const SurfaceContact& contact, double stored) const HD_RT {
  std::array<PressedObject, kMaxHolding> now{};
  std::array<double, kMaxHolding> share{};
  double all = 0;
  const std::uint32_t count = contact.parts > 0 ? contact.parts : contact.object != 0 ? 1 : 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const SceneObject* object = scene_.find(contact.parts > 0 ? contact.part[i].object : contact.object);
    if (object == nullptr) continue;
    now[i] = {object->id, object->surface.changes, object->shape.number, object->material.stiffness};
    if (!(now[i].stiffness > 0)) continue;  // It holds nothing yet.
    all += share[i] = contact.parts > 0 ? contact.part[i].force.squaredNorm() / now[i].stiffness : 1;
  }
  double put_in = 0;
  bool other_surface = false;
  for (std::uint32_t i = 0; i < count && all > 0; ++i) {
    for (const PressedObject& before : device.pressed) {
      if (before.object == 0 || before.object != now[i].object) continue;
      other_surface = other_surface || before.surface != now[i].surface || before.shape != now[i].shape;
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
  motion.most_damping = mostDamping(devices_[d].max_damping / devices_[d].mount.scale());
  const std::uint8_t k = object != nullptr ? bodies_.find(objectSlot(object->id)) : FreeBodies::kNone;
  if (k != FreeBodies::kNone && bodies_.moves(k)) {
    motion.r = out.contact.point - bodies_.body(k).body.com();
    motion.body = bodies_.mobility(k);
  }
  FingerForces pad;
  if (SoftFinger& finger = devices_[d].finger; finger.soft()) {
    pad = finger.settle(scene_, out.contact, motion, period());
  } else {
    // It is made by no more than that gain, which counts already.
    pad.force = padForce(out.contact, motion, out.contact.damping_gain, period()).force;
  }
  out.contact.force += pad.force;
  out.contact.apart += pad.force.cwiseProduct(out.contact.at_hip - out.contact.velocity);
  return pad;
}

}  // namespace hapticd
