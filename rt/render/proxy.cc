#include "rt/render/proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr double kSkin = 0x1p-40;         // Of the coordinates involved.
constexpr double kNear = 1.0 / 16;        // Of the skin: differences that are rounding.
constexpr double kSettled = 0x1p-30;      // Of the depth: a smaller move is not worth another look,
constexpr double kSettledLate = 0x1p-20;  // and this is not, late in a step that comes nearer by ever less.
constexpr std::uint32_t kLate = 16;       // Sweeps.
constexpr double kConeRounding = 1e-9;    // Of the radius of a friction cone.
constexpr double kMaxTurnCosine = 0.5;    // A curved surface's normal turns at most 60 degrees per plan.
constexpr int kMaxRounds = 12;            // Hits before the surfaces are looked at afresh.

Vec3 toLocal(const Pose& X, const Vec3& x) HD_RT { return X.q.conjugate() * (x - X.p); }

double extent(const Vec3& x) HD_RT { return x.cwiseAbs().maxCoeff(); }

}  // namespace

/** What one step works with. */
struct ProxyRenderer::Step {
  const Scene* scene = nullptr;
  Vec3 goal = Vec3::Zero();  ///< The hip.
  double scale = 0;          ///< Of the coordinates in W.
  bool together = true;      ///< The proxy is at one place in W, proxy_; else start_ holds one per object.
  bool judged = false;       ///< The friction state of this tick has been decided.
  bool slip = false;
  std::uint32_t work = 0;
  std::uint32_t sweeps = 0;
  std::uint32_t met = 0;  ///< Slot of the last surface met in this step, 0 for none.
  Constraint held[kMaxHalfSpaces];
  int count = 0;

  double settled() const HD_RT { return sweeps < kLate ? kSettled : kSettledLate; }
  double skin(const SceneObject& object) const HD_RT {
    const double size = std::isfinite(object.radius) ? object.radius : 0;
    return kSkin * (scale + extent(object.X_WO.p) + size);
  }
};

void ProxyRenderer::reset(const Vec3& hip_W) HD_RT {
  proxy_ = hip_W;
  object_ = 0;
  slip_ = false;
  started_ = true;
  behind_ = false;
}

void ProxyRenderer::step(const Scene& scene, const Vec3& hip_W, const Vec3& v_W, double,
                         SurfaceContact& contact) HD_RT {
  contact = SurfaceContact{};
  contact.proxy = proxy_;
  if (!isFinite(hip_W)) return;
  if (!started_) reset(hip_W);
  Step step;
  step.scene = &scene;
  step.goal = hip_W;
  step.scale = std::max(extent(proxy_), extent(hip_W));
  step.slip = slip_;
  begin(step);
  settle(step);
  finish(step, v_W, contact);
}

/** Puts the proxy where it was relative to each object, if any object has moved since. */
void ProxyRenderer::begin(Step& step) HD_RT {
  const auto touchable = step.scene->touchable();
  const auto moves = step.scene->triangleMoves();
  bool moved = behind_ || !moves.empty();
  for (const std::uint16_t slot : touchable) moved = moved || step.scene->slot(slot).moved;
  if (!moved) return;
  step.together = false;
  for (const std::uint16_t slot : touchable) {
    const SceneObject& object = step.scene->slot(slot);
    if (behind_ && start_id_[slot] == object.id) continue;
    start_[slot] = toLocal(object.X_WO_before, proxy_);
    start_id_[slot] = object.id;
  }
  if (moves.empty()) return;
  for (const std::uint16_t slot : touchable) {
    const SceneObject& object = step.scene->slot(slot);
    if (object.shape.kind != ShapeKind::kMesh) continue;
    const double skin = step.skin(object);
    const bool two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
    for (const TriangleMove& move : moves) {
      if (move.mesh == object.shape.mesh) (void)overtakes(move, two_sided, kNear * skin, start_[slot]);
    }
  }
}

Vec3 ProxyRenderer::startIn(const Step& step, std::uint32_t slot) const HD_RT {
  return step.together ? toLocal(step.scene->slot(slot).X_WO, proxy_) : start_[slot];
}

/** The proxy in W: carried along by the surface that holds it. */
Vec3 ProxyRenderer::here(const Step& step) const HD_RT {
  if (step.together || step.count == 0) return proxy_;
  const std::uint32_t slot = step.held[step.count - 1].slot;
  return step.scene->slot(slot).X_WO * start_[slot];
}

/**
 * Sweeps from where the proxy is to `target` against everything. False when the work is used up: then nothing is
 * known and the proxy must not move.
 */
bool ProxyRenderer::sweepTo(Step& step, const Vec3& target, bool& hit, std::uint32_t& slot, SweepHit& first) HD_RT {
  hit = false;
  if (++step.sweeps > kMaxSweeps) return false;
  first = SweepHit{};
  const Vec3 along = target - proxy_;
  const double along2 = along.squaredNorm();
  for (const std::uint16_t i : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(i);
    const double skin = step.skin(object);
    if (step.together) {  // A ball that the segment does not reach.
      const Vec3 r = object.center_W - proxy_;
      const double t = along2 > 0 ? std::clamp(r.dot(along) / along2, 0.0, 1.0) : 0.0;
      if ((r - t * along).squaredNorm() > (object.radius + skin) * (object.radius + skin)) continue;
    }
    Sweep sweep;
    sweep.a = startIn(step, i);
    sweep.d = toLocal(object.X_WO, target) - sweep.a;
    sweep.tolerance = kNear * skin;
    sweep.two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
    sweep.work = step.work;
    sweep.limit = kMaxWork;
    const SweepResult result = sweepShape(object.shape, sweep, first);
    step.work = sweep.work;
    if (result == SweepResult::kExhausted) return false;
    if (result == SweepResult::kHit) {
      hit = true;
      slot = i;
    }
  }
  return true;
}

/** Goes the fraction t of the way to `target`. */
void ProxyRenderer::moveBy(Step& step, const Vec3& target, double t) HD_RT {
  if (t <= 0) return;
  if (step.together) {
    proxy_ += t * (target - proxy_);
    return;
  }
  for (const std::uint16_t i : step.scene->touchable()) {
    start_[i] += t * (toLocal(step.scene->slot(i).X_WO, target) - start_[i]);
  }
  proxy_ += t * (target - proxy_);
}

void ProxyRenderer::arrive(Step& step, const Vec3& target) HD_RT {
  proxy_ = target;
  step.together = true;
}

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
  if ((last - here).norm() <= std::max(c.skin, step.settled() * (last - step.goal).norm())) return plan;
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
  const double settled = std::max(kNear * skin, step.settled() * (foot - step.goal).norm());
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
    plan.stay = (plan.target - at).norm() <= settled;
    return plan;
  }
  if (step.count == 1) {
    Plan curved = planOnCurve(step, at);
    if (curved.has_then) return curved;
  }
  plan.target = foot;
  plan.stay = (foot - at).norm() <= settled;
  return plan;
}

/** Moves the proxy as far as it goes. */
void ProxyRenderer::settle(Step& step) HD_RT {
  bool hit = false;
  std::uint32_t slot = 0;
  SweepHit first;
  for (;;) {
    step.count = 0;
    Plan next;
    next.target = step.goal;
    for (int round = 0;; ++round) {
      if (!sweepTo(step, next.target, hit, slot, first)) return;
      if (!hit) {
        arrive(step, next.target);
        if (next.has_then) {
          next.target = next.then;
          next.has_then = false;
          continue;
        }
        break;
      }
      if (round >= kMaxRounds) return;
      const double skin = step.skin(step.scene->slot(slot));
      if (first.height > 1.5 * skin) {
        const SceneObject& object = step.scene->slot(slot);
        const Vec3 a = startIn(step, slot);
        const double approach = -first.normal.dot(toLocal(object.X_WO, next.target) - a);
        moveBy(step, next.target, std::max(0.0, first.t - skin / approach));
      }
      hold(step, slot, first);
      next = plan(step);
      if (next.stay && step.together) return;
      if (next.stay) next.target = here(step);
    }
    if (step.count == 0) return;  // Arrived at the goal.
  }
}

void ProxyRenderer::finish(Step& step, const Vec3& v_W, SurfaceContact& contact) HD_RT {
  behind_ = !step.together;
  if (behind_) proxy_ = here(step);
  contact.work = step.work;
  HalfSpace exact[kMaxHalfSpaces];
  double rounding = 0;
  for (int i = 0; i < step.count; ++i) {
    exact[i] = step.held[i].surface;
    rounding = std::max(rounding, kNear * step.held[i].skin);
  }

  // The surfaces that hold the proxy against the hip; the proxy's hair above them is not felt.
  Vec3 foot = step.goal;
  std::uint32_t active = 0;
  Vec3 on_surface = proxy_;
  const bool held = step.count > 0 && nearestInside(exact, step.count, rounding, foot, active) && active != 0;
  if (held && !nearestOnPlanes(exact, active, on_surface)) on_surface = proxy_;
  const Vec3 pull = on_surface - step.goal;
  const bool touching = held || (pull.norm() > 0 && (step.count > 0 || proxy_ != step.goal));
  if (step.count > 0) step.met = step.held[foremost(step, active)].slot;
  const std::uint32_t object = step.met != 0 ? step.scene->slot(step.met).id : object_;
  const SceneObject* surface = touching ? step.scene->find(object) : nullptr;
  const bool before = object_ != 0;
  if (!surface) {
    contact.proxy = proxy_;
    contact.untouch = before;
    contact.left = object_;
    object_ = 0;
    slip_ = false;
    return;
  }
  const Vec3 support = held ? Vec3(foot - step.goal) : pull;
  contact.depth = support.norm();
  if (contact.depth > 0) contact.normal = support / contact.depth;
  const hd_material& material = surface->material;
  const double elastic = material.stiffness * pull.dot(contact.normal);
  const double approach = contact.normal.dot(surface->velocityAt(on_surface) - v_W);
  contact.force = material.stiffness * pull + std::max(material.damping * approach, -elastic) * contact.normal;
  contact.proxy = on_surface;
  contact.object = object;
  contact.touch = !before;
  slip_ = step.slip && material.friction_static > 0;
  contact.slip = slip_;
  object_ = object;
}

}  // namespace hapticd
