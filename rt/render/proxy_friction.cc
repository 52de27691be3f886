// What a proxy rubs on whose looks at the surfaces have brought it no nearer: for its contact's normal and depth.
#include "rt/render/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kInCone = 1 + 0x1p-10;   // Of the static cone: on a curve each look ends a little aside,
constexpr double kSettledLate = 0x1p-20;  // and without friction by less of the depth.

}  // namespace

/**
 * Lets the surface below the proxy hold it where it is, with those it meets from there on the way to the border of its
 * cone, if they and friction on them keep it from the hip. Else what keeps it there is taken to push straight from hip
 * to proxy, which without friction is true.
 */
void ProxyRenderer::holdByFriction(Step& step) HD_RT {
  Vec3 target = step.goal;
  bool rubs = false;
  for (int i = 0; i < kMaxInGroove; ++i) {
    bool hit = false;
    std::uint32_t slot = 0;
    SweepHit first;
    if (!sweepTo(step, target, Vec3::Zero(), hit, slot, first)) break;
    if (!hit && rubs) return;  // It has not come to the border yet, but is on its way along these.
    if (!hit) break;
    const hd_material& material = step.scene->slot(slot).material;
    rubs = material.friction_static > 0;
    meet(step, target, slot, first);
    HalfSpace planes[kMaxHalfSpaces];
    for (int k = 0; k < step.count; ++k) planes[k] = step.held[k].surface;
    Vec3 foot = step.goal;
    std::uint32_t active = 0;
    if (!nearestInside(planes, step.count, kNear * step.held[0].skin, foot, active) || active == 0) break;
    const Vec3 lag = proxy_ - foot;
    const double depth = (foot - step.goal).norm(), length = lag.norm();
    const double cone = std::max(kInCone * material.friction_static, kSettledLate) * depth;
    if (length <= cone + step.held[0].skin) return;
    target = foot + material.friction_dynamic * depth / length * lag;
  }
  step.count = 0;
}

}  // namespace hapticd
