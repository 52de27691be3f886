// What the surfaces that hold the proxy do to the hand: each with the material and the motion of its object.
#include "rt/render/proxy/press.h"
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {

namespace {

/** What of x, a sum of the normals, falls to each; none negative. */
void shareOut(const HoldingSurface* held, int count, const Vec3& x, double* of) HD_RT {
  const Vec3 &one = held[0].normal, &other = held[1].normal;
  const Vec3 third = count == 3 ? held[2].normal : one.cross(other);
  const Vec3 part = x / one.cross(other).dot(third);  // Of planes that nearestOnPlanes() has told apart.
  of[0] = std::max(0.0, part.dot(other.cross(third)));
  of[1] = std::max(0.0, part.dot(third.cross(one)));
  if (count == 3) of[2] = std::max(0.0, part.dot(one.cross(other)));
}

}  // namespace

/** The active surfaces, and how they share in `up`, from hip to foot. */
int ProxyRenderer::holders(const Step& step, std::uint32_t active, const Vec3& up, HoldingSurface* out) const HD_RT {
  int count = 0;
  for (int i = 0; i < step.count && count < kMaxHolding; ++i) {
    if (!(active >> i & 1u)) continue;
    const Constraint& c = step.held[i];
    out[count++] = {step.scene->slot(c.slot).id, c.feature, c.kind, c.corner, c.surface.normal,
                    up.dot(c.surface.normal)};
  }
  if (count < 2) return count;
  double push[kMaxHolding];
  shareOut(out, count, up, push);
  for (int i = 0; i < count; ++i) out[i].push = push[i];
  return count;
}

/** Tells which surfaces hold the proxy, if any of them is shaded, rings or has a relief. */
void ProxyRenderer::noteHolding(const Step& step, std::uint32_t active, const Vec3& up) HD_RT {
  bool asked = false;
  for (int i = 0; i < step.count; ++i) {
    const Surface& surface = step.scene->slot(step.held[i].slot).surface;
    asked = asked || surface.parameters.smooth_cosine > 0 || surface.parameters.transient_gain > 0 ||
            surface.relief != nullptr;
  }
  if (asked) holding_count_ = holders(step, active, up, holding_.data());
}

/**
 * Friction of the active surfaces, of which `object` has one. Of several objects with forces F_i the cone is |sum of
 * mu_i F_i| wide: for equal ones mu |F|, about the resultant; and no narrower than one wall's alone beside others at
 * right angles. A surface that comes in or goes presses with nothing, so friction does not jump.
 */
Friction ProxyRenderer::frictionOf(const Step& step, const SceneObject& object, std::uint32_t active,
                                   const Vec3& up) const HD_RT {
  const auto of = [](const SceneObject& o) HD_RT {
    return Friction{o.material.friction_static, o.material.friction_dynamic};
  };
  const Friction first = of(object);
  if (!step.isHeldBySeveral(active)) [[likely]]
    return first;

  HoldingSurface held[kMaxHolding];
  const int count = holders(step, active, up, held);
  Vec3 force = Vec3::Zero(), still = force, sliding = force;
  Friction least = first, most = first;
  for (int i = 0; i < count; ++i) {
    const SceneObject& other = *step.scene->find(held[i].object);
    const Friction mu = of(other);
    const Vec3 newtons = held[i].push * other.material.stiffness * held[i].normal;
    force += newtons;
    still += mu.still * newtons;
    sliding += mu.sliding * newtons;
    least = {std::min(least.still, mu.still), std::min(least.sliding, mu.sliding)};
    most = {std::max(most.still, mu.still), std::max(most.sliding, mu.sliding)};
  }
  const double all = force.norm();
  if (!(all > 0)) return first;
  Friction mean{std::clamp(still.norm() / all, least.still, most.still),
                std::clamp(sliding.norm() / all, least.sliding, most.sliding)};
  mean.sliding = std::min(mean.sliding, mean.still);  // Where walls press against each other it may be more.
  return mean;
}

/**
 * What presses on a hand whose proxy is held by the active surfaces, `up` above it, with their point of contact at x.
 * One object presses with its own material. Of several each presses with its own (press()), and damps and carries by
 * its push; then `contact`, which knows its proxy, is told each one's part.
 */
ProxyRenderer::Press ProxyRenderer::pressOf(const Step& step, const SceneObject& object, std::uint32_t feature,
                                            std::uint32_t active, const Vec3& up, const Vec3& x,
                                            SurfaceContact* contact) const HD_RT {
  const double depth = up.norm();
  Press all;
  if (depth > 0) all.normal = up / depth;
  all.stiffness = all.stored = object.material.stiffness;
  all.damping = std::min(object.material.damping, max_damping_);
  all.velocity = step.scene->velocityAt(object, feature, x);
  const Vec3 out = step.goal - x;
  all.at_hip = all.velocity + object.V_WO.w.cross(out);
  if (!step.isHeldBySeveral(active)) [[likely]]
    return all;

  HoldingSurface held[kMaxHolding];
  const int count = holders(step, active, up, held);
  Pressing part[kMaxPressing];
  Vec3 velocity[kMaxPressing];
  double pushes = 0, damping = 0;
  Vec3 mean = Vec3::Zero(), mean_at_hip = mean, at_hip[kMaxPressing];
  bool alike = true;
  for (int i = 0; i < count; ++i) {
    const SceneObject& other = *step.scene->find(held[i].object);
    part[i] = {held[i].normal, held[i].push, other.material.stiffness};
    velocity[i] = step.scene->velocityAt(other, held[i].feature, x);
    pushes += held[i].push;
    const double damps = std::min(other.material.damping, max_damping_);
    damping += held[i].push * damps;
    at_hip[i] = velocity[i] + other.V_WO.w.cross(out);
    mean += held[i].push * velocity[i];
    mean_at_hip += held[i].push * at_hip[i];
    alike = alike && part[i].stiffness == all.stiffness && damps == all.damping && velocity[i] == all.velocity &&
            at_hip[i] == all.at_hip;
  }
  if (count < 2 || !(pushes > 0)) return all;
  const Vec3 force = press({part, static_cast<std::size_t>(count)}, up);
  double newtons[kMaxHolding];
  shareOut(held, count, force, newtons);
  for (int i = 0; contact && i < count; ++i) {
    contact->part[contact->parts++] = {held[i].object, contact->proxy - radius_ * held[i].normal,
                                       newtons[i] * held[i].normal, held[i].push / pushes};
  }
  const double sum = force.norm();
  if (alike || !(sum > 0)) return all;
  all.normal = force / sum;
  all.turned = depth * all.normal - up;
  all.stiffness = sum / depth;
  all.stored = force.dot(up) / (depth * depth);
  all.damping = damping / pushes;
  all.velocity = mean / pushes;
  all.at_hip = mean_at_hip / pushes;
  for (int i = 0; i < count; ++i) all.apart += newtons[i] * held[i].normal.cwiseProduct(at_hip[i] - all.at_hip);
  return all;
}

}  // namespace hapticd
