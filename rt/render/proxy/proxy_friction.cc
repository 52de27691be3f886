// Friction where surfaces turn: the way to the border of the cone on one, and what a proxy lies and rubs on whose tick
// ends before it has come to rest, for its contact's normal and depth.
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kInCone = 1 + 0x1p-10;  // Of the cone: on a curve each look ends a little aside.

constexpr int kMaxBorderTurns = 48;    // Of the tangent plane of a curve, to the border of its cone,
constexpr double kAtBorder = 0x1p-32;  // and what is left of the depth then.
constexpr double kLonger = 4;          // Times the last turn's, where the cone does not come nearer by less.
constexpr double kShortOfFoot = 0.875;

constexpr double kSameWay = 1 - 0x1p-40;  // Cosine of rounding.
constexpr double kFarBeside = 0x1p20;     // Skins: who is at a surface meets it in so short a way, or goes along it.

}  // namespace

/**
 * On a single curved surface, be it a ball's edge or vertex: to where it lies on the border of the cone of `friction`,
 * found by turning the tangent plane before anything is swept; over the edge in which that meets the present one.
 */
bool ProxyRenderer::slideOnCurve(Step& step, const Vec3& at, double friction, double rest, Plan& plan) const HD_RT {
  const Constraint& c = step.held[0];
  const SceneObject& object = step.scene->slot(c.slot);
  if (c.kind == FeatureKind::kFace && !isCurved(object.shape, c.feature)) return false;
  Constraint& there = step.held[1];
  Vec3 last = at;
  double depth = 0, slid = 0, before = 0;
  for (int turn = 0;; ++turn) {
    if (!tangentTo(object, c, object.toLocal(last), there)) return false;
    const bool rolls = there.kind != c.kind;  // Off an edge; a mesh is left to followFaces().
    if (rolls && object.shape.kind == ShapeKind::kMesh) return false;
    const Vec3& n = there.surface.normal;
    depth = -there.surface.height(step.goal);
    // On the flat face beyond an edge, in one straight line from where it is.
    const Vec3 foot = step.goal + (depth + c.skin) * n, along = (rolls ? at : last) - foot;
    const Vec3 lag = along - along.dot(n) * n;
    const double r = lag.norm();
    if (!(depth > 0 && r > 0)) return false;
    // As the cone has come nearer with the last turn (secants), for deep in a curve it does so by ever less.
    const double out = r - friction * depth, most = std::min(kLonger * std::abs(slid), kShortOfFoot * r);
    double slide = out;
    if (turn > 0 && !rolls) {
      const double nearer = (before - out) / slid;
      slide = nearer * most > std::abs(out) ? out / nearer : std::copysign(most, out);
    }
    const Vec3 next = foot + (1 - slide / r) * lag, move = next - last;
    last = next;
    if (move.norm() <= std::max(kNear * c.skin, kAtBorder * depth)) break;
    if (turn == kMaxBorderTurns) return false;
    slid = slide;
    before = out;
  }
  if ((last - at).norm() <= rest) {  // A skin aside, and the plane there is turned by more than that.
    plan.goTo(at);
    return plan.stay = true;
  }
  const HalfSpace planes[2] = {{c.surface.normal, c.surface.offset + c.skin},
                               {there.surface.normal, there.surface.offset + c.skin}};
  Vec3 over = last;
  if (planes[1].normal.dot(planes[0].normal) < kMaxTurnCosine || !nearestOnPlanes(planes, 3, over) ||
      (step.together && leadsAway(at, last, step.goal)))
    return false;
  plan.goTo(over);
  plan.way[plan.parts++] = last;
  plan.above[0] = planes[0].normal;
  plan.above[1] = planes[1].normal;
  plan.lands = isOnFeature(object, there, object.toLocal(last));
  plan.keeps = 2;
  return true;
}

/**
 * What a twist about the normal leaves of friction to a proxy that is r from the foot, d deep, on stiffness k: within
 * the ellipse of thesis eq. 2.48 it sticks; from beyond it comes back along the line to the goal (eq. 2.50), to
 * r / sqrt(x^2 + y^2). Asked only where the step begins, of all that holds it there: each look from a place nearer
 * would leave it less.
 */
void ProxyRenderer::shareFriction(Step& step, double k, double r, double d, Friction& friction) const HD_RT {
  if (!step.shares || !step.judged) {
    const auto share = [&](double coefficient) HD_RT {
      const double bears = coefficient * k * d * load_.arm;
      return bears > 0 ? load_.moment / bears : std::numeric_limits<double>::infinity();
    };
    const double y = share(friction.still), x = r / (friction.sliding * d), y_sliding = share(friction.sliding);
    step.part.still = std::sqrt(std::max(0.0, 1 - y * y));
    const double all = std::hypot(x, y_sliding);
    step.part.sliding = std::isfinite(all) && all > 0 ? x / all : 0.0;
    step.shares = true;
  }
  friction = {friction.still * step.part.still, friction.sliding * step.part.sliding};
}

/** Whether the ball, where it is, touches no face of the meshes that hold it but those that do. */
bool ProxyRenderer::isBesideNoFace(Step& step) const HD_RT {
  for (int i = 0; i < step.count; ++i) {
    const std::uint32_t slot = step.held[i].slot;
    const SceneObject& object = step.scene->slot(slot);
    if (object.shape.kind != ShapeKind::kMesh) continue;
    Vec3 ways[kMaxHalfSpaces];
    NearestQuery query;
    query.x = object.toLocal(proxy_);
    query.reach = radius_ + 2 * kFarBeside * step.held[i].skin;
    query.cosine = kSameWay;
    query.ways = ways;
    for (int k = 0; k < step.count; ++k)
      if (step.held[k].slot == slot) ways[query.way_count++] = object.R_WO.transpose() * step.held[k].surface.normal;
    query.vicinity = step.vicinity(slot);
    query.work = step.work;
    query.limit = kMaxWork;
    Nearest near;
    const NearestResult result = nearestOnMesh(*object.shape.mesh, query, near);
    step.work = query.work;
    if (result != NearestResult::kNone) return false;
  }
  return true;
}

/**
 * A proxy that lies on a floor and sticks to a wall needs no floor to stay there; the hand, deep in both, does: how
 * hard the floor is must not hang on whether friction on the wall would do. So what is at the proxy, on the way to
 * where it would be without friction, holds it too: another object, or another face of a mesh. True if there was one.
 */
bool ProxyRenderer::meetBeside(Step& step) HD_RT {
  const bool known = step.again && looked_.count == step.count && looked_.at == proxy_;
  const bool alone = known && looked_.alone;
  if ((alone && step.scene->touchable().size() < 2) || step.count == 0 || step.count == kMaxHalfSpaces) return false;
  HalfSpace above[kMaxHalfSpaces];
  double skin = 0;
  bool rubs = false;
  for (int i = 0; i < step.count; ++i) {
    above[i] = step.held[i].surface;
    above[i].offset += step.held[i].skin;
    skin = std::max(skin, step.held[i].skin);
    rubs = rubs || step.scene->slot(step.held[i].slot).material.friction_static > 0;
  }
  if (!rubs) return false;
  Vec3 foot = step.goal;
  std::uint32_t active = 0, slot = 0;
  if (!nearestInside(above, step.count, kNear * skin, foot, active)) return false;
  const Vec3 at = here(step);
  const double way = (foot - at).norm();
  if (!(way > kAt * skin)) return false;
  bool hit = false;
  SweepHit first;
  const auto isThere = [&](Beside beside) HD_RT {
    return sweepTo(step, foot, Vec3::Zero(), hit, slot, first, beside) && hit &&
           first.height <= kAt * step.skin(step.scene->slot(slot));
  };
  // Where its places relative to the objects are apart, the ways to other ones are longer, and lead elsewhere.
  bool there = !step.together && isThere(Beside::kHolders);
  if (!there) {
    if (way > kFarBeside * skin) foot = at + kFarBeside * skin / way * (foot - at);
    there = isThere(!step.together ? Beside::kAllButFaces : alone ? Beside::kHolders : Beside::kHolding);
    if (step.again && !known && radius_ > 0) looked_ = {step.count, proxy_, isBesideNoFace(step)};
  }
  if (there) meet(step, foot, slot, first);
  return there;
}

/**
 * Where a tick ends before the proxy has come to rest: lets the surface below hold it, with those it meets from there
 * on the way to the border of its cone (without friction: to where they let it be), so that normal and depth are
 * theirs. Where that way is free at last it goes there. If nothing is met, what keeps it from the hip is taken to push
 * straight from hip to proxy.
 */
void ProxyRenderer::holdWhereItIs(Step& step) HD_RT {
  Vec3 target = step.goal;
  bool rubs = false;
  for (int i = 0; i <= kMaxInGroove; ++i) {
    bool hit = false;
    std::uint32_t slot = 0;
    SweepHit first;
    if (!sweepTo(step, target, Vec3::Zero(), hit, slot, first)) break;
    if (!hit && i == 0) break;
    if (!hit) {
      step.slip = rubs;
      arrive(step, target);
      return;
    }
    if (i == kMaxInGroove) break;
    meet(step, target, slot, first);
    HalfSpace above[kMaxHalfSpaces];
    for (int k = 0; k < step.count; ++k) {
      above[k] = step.held[k].surface;
      above[k].offset += step.held[k].skin;
    }
    Vec3 foot = step.goal;
    std::uint32_t active = 0;
    if (!nearestInside(above, step.count, kNear * step.held[0].skin, foot, active) || active == 0) break;
    Friction mu = frictionOf(step, step.scene->slot(step.held[foremost(step, active)].slot), active, foot - step.goal);
    rubs = mu.still > 0;
    if (step.shares) mu = {mu.still * step.part.still, mu.sliding * step.part.sliding};
    const Vec3 lag = proxy_ - foot;
    const double depth = (foot - step.goal).norm(), length = lag.norm();
    const double cone = std::max(kInCone * (step.slip ? mu.sliding : mu.still), kSettledLate) * depth;
    if (length <= cone + step.held[0].skin) return;
    target = foot + mu.sliding * depth / length * lag;
  }
  step.count = 0;
}

}  // namespace hapticd
