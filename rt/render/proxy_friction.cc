// What a proxy rubs on whose looks at the surfaces have brought it no nearer: for its contact's normal and depth.
#include "rt/render/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kInCone = 1 + 0x1p-10;  // Of the static cone: on a curve each look ends a little aside.

}  // namespace

/**
 * Lets the surface below the proxy hold it where it is, if friction on that surface alone keeps it from the hip. Else
 * what keeps it there is taken to push straight from hip to proxy, which without friction is true.
 */
void ProxyRenderer::holdByFriction(Step& step) HD_RT {
  bool hit = false;
  std::uint32_t slot = 0;
  SweepHit first;
  if (!sweepTo(step, step.goal, Vec3::Zero(), hit, slot, first) || !hit) return;
  const double mu = step.scene->slot(slot).material.friction_static;
  if (!(mu > 0)) return;
  meet(step, step.goal, slot, first);
  const HalfSpace& plane = step.held[0].surface;
  const double depth = -plane.height(step.goal);
  const Vec3 lag = proxy_ - (step.goal + depth * plane.normal);
  const double most = kInCone * mu * depth + step.held[0].skin;
  if (!(depth > 0 && lag.squaredNorm() <= most * most)) step.count = 0;
}

}  // namespace hapticd
