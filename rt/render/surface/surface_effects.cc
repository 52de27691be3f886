#include "rt/render/surface/surface_effects.h"

#include <algorithm>
#include <cmath>

#include "rt/render/surface/relief.h"

namespace hapticd {
namespace {

/** A surface that presses on the hand. Vectors in W. */
struct Pressed {
  const SceneObject* object = nullptr;
  Vec3 normal;           ///< Outward, unit.
  Vec3 force;            ///< Of this surface on the hand, as it is without relief [N].
  double stiffness = 0;  ///< [N/m].
  double depth = 0;      ///< Of the hand, as deep as it presses with that [m].
  Vec3 foot;             ///< Of the hand on it: with friction the proxy stays behind; the relief does not.
  Vec3 velocity;         ///< Where the hand is; where vertices move not that of the frame, in which the relief lies.
};

/**
 * The relief lowers the surface by h <= 0 along its normal: with the depth d the elastic energy is that of max(0, d +
 * h), and the force is k (d + h) (n - grad h) where without relief it was k d n. So the contact's force, friction with
 * it, shrinks to the share (d + h) / d, and the slope pushes aside. On a plane no tour gives any energy.
 * Adds what that changes to `forces`; tells d + h, 0 for a hand above the lowered surface. What turns gives the power
 * of its slopes' force where the hand is, for in the object's frame it is there that the energy has that gradient.
 */
double addRelief(const Pressed& by, const Vec3& hip, SurfaceForces& forces) HD_RT {
  const Surface& surface = by.object->surface;
  if (!surface.relief || !(by.depth > 0)) return by.depth;
  const Pose& X_WO = by.object->X_WO;
  const Quat q_OW = X_WO.q.conjugate();
  const Vec3 n_O = q_OW * by.normal;
  const ReliefPoint relief = reliefAt(*surface.relief, surface.parameters, q_OW * (by.foot - X_WO.p), n_O);
  const double left = std::max(0.0, by.depth + relief.height);
  const Vec3 aside_O = relief.gradient - relief.gradient.dot(n_O) * n_O;
  const Vec3 shrunk = (left / by.depth - 1) * by.force, aside = -by.stiffness * left * (X_WO.q * aside_O);
  forces.relief += shrunk + aside;
  forces.carried += shrunk.cwiseProduct(by.velocity) + aside.cwiseProduct(by.object->velocityAt(hip));
  return left;
}

double square(double x) HD_RT { return x * x; }

/**
 * Of all that presses, each with its own relief, and of friction and damping with its share. Tells with how much the
 * surface of `touched` still presses [N].
 */
double addReliefs(const Scene& scene, const SceneObject& touched, const SurfaceContact& contact,
                  std::span<const HoldingSurface> holding, const Vec3& hip, SurfaceForces& forces) HD_RT {
  const double radius = (contact.proxy - contact.point).norm();  // A ball touches that far below its centre.
  if (contact.parts == 0) {
    const Vec3 foot = hip + (contact.depth - radius) * contact.smooth;
    const double left = addRelief(
        {&touched, contact.smooth, contact.force, contact.stiffness, contact.depth, foot, contact.at_hip}, hip, forces);
    forces.stored = square(left / contact.depth) * contact.stored;
    return contact.stiffness * left;
  }
  Vec3 rest = contact.force;
  for (std::uint32_t i = 0; i < contact.parts; ++i) rest -= contact.part[i].force;
  double load = 0, stored = 0, without = 0;
  for (std::uint32_t i = 0; i < contact.parts; ++i) {
    const ContactPart& part = contact.part[i];
    const SceneObject* object = scene.find(part.object);
    const double newtons = part.force.norm();
    if (!object || !(newtons > 0)) continue;
    const Vec3 n = part.force / newtons;
    const double stiffness = object->material.stiffness;
    if (!(stiffness > 0)) continue;  // In a groove it takes up what the other's force leans on it, at no depth.
    const Vec3 foot = hip + (n.dot(contact.proxy - hip) - radius) * n;
    const auto held = std::ranges::find(holding, part.object, &HoldingSurface::object);
    const Vec3 velocity =
        held != holding.end() ? scene.velocityAt(*object, held->feature, part.point) : object->velocityAt(part.point);
    const Vec3 at_hip = velocity + object->V_WO.w.cross(hip - part.point);
    const double depth = newtons / stiffness;
    const double left =
        addRelief({object, n, part.force + part.share * rest, stiffness, depth, foot, at_hip}, hip, forces);
    stored += stiffness * square(left);
    without += stiffness * square(depth);
    if (object == &touched) load += stiffness * left;
  }
  if (without > 0) forces.stored = stored / without * contact.stored;
  return load;
}

}  // namespace

/** An impact on each object that pushes and is not felt since before; that of the contact pushes if it is `felt`. */
void SurfaceEffects::strike(const Scene& scene, const SurfaceContact& contact, std::span<const HoldingSurface> holding,
                            bool felt, const Vec3& hip, const Vec3& v) HD_RT {
  if (!felt && holding.empty() && felt_.id[0] == 0) return;
  const Felt before = felt_;
  std::size_t count = 0;
  felt_.id.fill(0);
  const auto touch = [&](std::uint32_t id, const Vec3& normal, const HoldingSurface* second) HD_RT {
    if (std::ranges::find(felt_.id, id) != felt_.id.end()) return;
    felt_.id[count] = id;
    const SceneObject* object = scene.find(id);
    if (object && away_ > 0) felt_.at[count] = object->toLocal(hip);
    ++count;
    if (!object || std::ranges::find(before.id, id) != before.id.end()) return;
    const Vec3 moving = second ? scene.velocityAt(*object, second->feature, contact.point) : contact.velocity;
    const double speed = normal.dot(moving - v);
    if (speed >= Transient::kLeastSpeed + noise_) transient_.strike(object->surface.parameters, speed, normal);
  };
  if (felt) touch(contact.object, contact.normal, nullptr);
  for (const HoldingSurface& surface : holding) {
    if (surface.object != contact.object && surface.push > 0) touch(surface.object, surface.normal, &surface);
  }
  if (!(away_ > 0)) return;
  for (std::size_t i = 0; i < before.id.size() && count < before.id.size(); ++i) {
    const SceneObject* object = scene.find(before.id[i]);
    if (!object || std::ranges::find(felt_.id, before.id[i]) != felt_.id.end()) continue;
    const Vec3 at = object->toLocal(hip);
    if ((at - before.at[i]).squaredNorm() > away_ * away_) continue;
    felt_.at[count] = before.at[i];
    felt_.id[count++] = before.id[i];
  }
}

SurfaceForces SurfaceEffects::step(const Scene& scene, const SurfaceContact& contact,
                                   std::span<const HoldingSurface> holding, const Vec3& hip, const Vec3& v) HD_RT {
  SurfaceForces forces;
  forces.stored = contact.stored;
  const SceneObject* object = scene.find(contact.object);
  const Surface* surface = object && contact.depth > 0 ? &object->surface : nullptr;
  const Vec3 slide = surface ? Vec3(v - contact.at_hip) : Vec3(Vec3::Zero());

  // What the surface touched presses with.
  const double normal_force = surface ? addReliefs(scene, *object, contact, holding, hip, forces) : 0;

  const bool felt = normal_force > 0;
  strike(scene, contact, holding, felt, hip, v);
  forces.transient = transient_.step();

  if (felt && surface->vibration) {
    // Across the motion, as the paper has it: such a force does no work on the sliding hand.
    const Vec3 aside = contact.smooth.cross(slide);
    const double speed = aside.norm();
    const double heard = std::sqrt(std::max(0.0, speed * speed - noise_ * noise_));
    const double wanted =
        surface->parameters.vibration_mass * vibration_.step(*surface->vibration, heard, normal_force);
    if (speed > 0) forces.vibration = std::clamp(wanted, -normal_force, normal_force) / speed * aside;
  } else {
    vibration_.rest();
  }
  return forces;
}

}  // namespace hapticd
