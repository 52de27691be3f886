#include "rt/render/surface_effects.h"

#include <algorithm>
#include <cmath>

#include "rt/render/relief.h"

namespace hapticd {
namespace {

/**
 * The relief lowers the surface by h <= 0 along its normal: with the depth d the elastic energy is that of max(0, d +
 * h), and the force is k (d + h) (n - grad h) where without relief it was k d n. So the contact's force, friction with
 * it, shrinks to the share (d + h) / d, and the slope pushes aside. On a plane no tour gives any energy.
 * `left` becomes d + h, 0 for a hand above the lowered surface.
 */
Vec3 reliefForce(const SceneObject& object, const SurfaceContact& contact, const Vec3& hip, double& left) HD_RT {
  const Quat q_OW = object.X_WO.q.conjugate();
  // With friction the proxy stays behind; the relief does not. A ball touches a radius below its centre.
  const Vec3 foot = hip + (contact.depth - (contact.proxy - contact.point).norm()) * contact.smooth;
  const Vec3 n_O = q_OW * contact.smooth;
  const ReliefPoint relief =
      reliefAt(*object.surface.relief, object.surface.parameters, q_OW * (foot - object.X_WO.p), n_O);
  left = std::max(0.0, contact.depth + relief.height);
  const Vec3 aside_O = relief.gradient - relief.gradient.dot(n_O) * n_O;
  return (left / contact.depth - 1) * contact.force - object.material.stiffness * left * (object.X_WO.q * aside_O);
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
    if (object && away_ > 0) felt_.at[count] = object->X_WO.q.conjugate() * (hip - object->X_WO.p);
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
    const Vec3 at = object->X_WO.q.conjugate() * (hip - object->X_WO.p);
    if ((at - before.at[i]).squaredNorm() > away_ * away_) continue;
    felt_.at[count] = before.at[i];
    felt_.id[count++] = before.id[i];
  }
}

SurfaceForces SurfaceEffects::step(const Scene& scene, const SurfaceContact& contact,
                                   std::span<const HoldingSurface> holding, const Vec3& hip, const Vec3& v) HD_RT {
  SurfaceForces forces;
  const SceneObject* object = scene.find(contact.object);
  const Surface* surface = object && contact.depth > 0 ? &object->surface : nullptr;
  const Vec3 slide = surface ? Vec3(v - contact.velocity) : Vec3::Zero();

  double left = surface ? contact.depth : 0;
  if (surface && surface->relief) forces.texture += reliefForce(*object, contact, hip, left);

  const bool felt = left > 0;
  strike(scene, contact, holding, felt, hip, v);
  forces.transient = transient_.step();

  if (felt && surface->vibration) {
    // Across the motion, as the paper has it: such a force does no work on the sliding hand.
    const Vec3 aside = contact.smooth.cross(slide);
    const double speed = aside.norm(), normal_force = object->material.stiffness * left;
    const double heard = std::sqrt(std::max(0.0, speed * speed - noise_ * noise_));
    const double wanted =
        surface->parameters.vibration_mass * vibration_.step(*surface->vibration, heard, normal_force);
    if (speed > 0) forces.texture += std::clamp(wanted, -normal_force, normal_force) / speed * aside;
  } else {
    vibration_.rest();
  }
  return forces;
}

}  // namespace hapticd
