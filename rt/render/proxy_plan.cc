// Which surfaces hold the proxy, and where they and friction let it go.
#include "rt/render/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kSettled = 0x1p-30;      // Of the depth: a smaller move is not worth another look,
constexpr double kSettledLate = 0x1p-20;  // and this is not, late in a step that comes nearer by ever less.
constexpr std::uint32_t kLate = 16;       // Sweeps.
constexpr double kConeRounding = 1e-9;    // Of the radius of a friction cone.
constexpr double kMaxTurnCosine = 0.5;    // A curved surface's normal turns at most 60 degrees per plan.

double settled(std::uint32_t sweeps) HD_RT { return sweeps < kLate ? kSettled : kSettledLate; }

}  // namespace

/** Of the active surfaces the one that gives material and name: that of the last tick, else the last one met. */
int ProxyRenderer::foremost(const Step& step, std::uint32_t active) const HD_RT {
  int last = step.count - 1;
  for (int i = 0; i < step.count; ++i) {
    if (!(active >> i & 1u)) continue;
    if (step.scene->slot(step.held[i].slot).id == object_) return i;
    last = i;
  }
  return last;
}

/** Adds the surface met to those that hold the proxy; those left behind go. */
void ProxyRenderer::hold(Step& step, std::uint32_t slot, const SweepHit& hit) HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  Constraint met;
  met.slot = step.met = slot;
  met.feature = hit.feature;
  met.surface.normal = object.X_WO.q * hit.normal;
  met.surface.offset = hit.offset + met.surface.normal.dot(object.X_WO.p);
  met.skin = step.skin(object);
  int kept = 0;
  for (int i = 0; i < step.count; ++i) {
    const Constraint& c = step.held[i];
    if (c.slot == met.slot && c.feature == met.feature) continue;
    const Vec3 x = step.together ? proxy_ : Vec3(step.scene->slot(c.slot).X_WO * start_[c.slot]);
    if (c.surface.height(x) <= 2 * c.skin && kept < kMaxHalfSpaces - 1) step.held[kept++] = c;
  }
  step.held[kept] = met;
  step.count = kept + 1;
}

/** On a single curved surface: over the edge of two tangent planes to the point nearest to the goal. */
ProxyRenderer::Plan ProxyRenderer::planOnCurve(Step& step, const Vec3& here) HD_RT {
  Plan plan;
  const Constraint& c = step.held[0];
  const SceneObject& object = step.scene->slot(c.slot);
  Vec3 normal;
  double offset = 0;
  if (!tangentNearest(object.shape, c.feature, toLocal(object.X_WO, step.goal), normal, offset)) return plan;
  normal = object.X_WO.q * normal;
  const double cosine = normal.dot(c.surface.normal);
  if (cosine < kMaxTurnCosine) return plan;  // Far to go: along the tangent plane, and again from there.
  offset += normal.dot(object.X_WO.p);
  const HalfSpace planes[2] = {{c.surface.normal, c.surface.offset + c.skin}, {normal, offset + c.skin}};
  Vec3 last = step.goal;
  if (!nearestOnPlanes(planes, 2, last)) return plan;
  Vec3 over = last;
  if (!nearestOnPlanes(planes, 3, over)) return plan;
  if ((last - here).norm() <= std::max(c.skin, settled(step.sweeps) * (last - step.goal).norm())) return plan;
  plan.target = over;
  plan.then = last;
  plan.has_then = true;
  return plan;
}

/** Where the surfaces that hold the proxy, and friction, let it go. */
ProxyRenderer::Plan ProxyRenderer::plan(Step& step) HD_RT {
  Plan plan;
  const Vec3 at = here(step);
  HalfSpace above[kMaxHalfSpaces], exact[kMaxHalfSpaces];
  double skin = 0;
  for (int i = 0; i < step.count; ++i) {
    exact[i] = above[i] = step.held[i].surface;
    above[i].offset += step.held[i].skin;
    skin = std::max(skin, step.held[i].skin);
  }
  Vec3 foot = step.goal;
  std::uint32_t active = 0;
  if (!nearestInside(above, step.count, kNear * skin, foot, active)) {
    plan.stay = true;
    return plan;
  }
  const double rest = std::max(kNear * skin, settled(step.sweeps) * (foot - step.goal).norm());
  const hd_material& material = step.scene->slot(step.held[foremost(step, active)].slot).material;
  if (material.friction_static > 0) {
    Vec3 on_surface = step.goal;
    if (!nearestOnPlanes(exact, active, on_surface)) on_surface = foot;
    const Vec3 lag = at - foot;
    const double r = lag.norm(), d = (on_surface - step.goal).norm();
    if (!step.judged) {
      step.judged = true;
      if (step.slip && r < material.friction_dynamic * d * (1 - kConeRounding)) step.slip = false;
    }
    const double cone = (step.slip ? material.friction_dynamic : material.friction_static) * d;
    if (r <= cone * (1 + kConeRounding)) {
      plan.target = at;
      plan.stay = true;
      return plan;
    }
    step.slip = true;
    plan.target = foot + lag * (material.friction_dynamic * d / r);
    plan.stay = (plan.target - at).norm() <= rest;
    return plan;
  }
  if (step.count == 1) {
    Plan curved = planOnCurve(step, at);
    if (curved.has_then) return curved;
  }
  plan.target = foot;
  plan.stay = (foot - at).norm() <= rest;
  return plan;
}

}  // namespace hapticd
