#include "rt/render/proxy/proxy.h"

#include <limits>

#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr int kMaxRounds = 12;        // Hits before the surfaces are looked at afresh,
constexpr int kMaxVain = 2;           // and that without having come nearer: round and round.
constexpr double kMostBack = 0x1p14;  // Times rounding that a proxy is put back onto its surfaces,
constexpr double kHovers = 32;        // Times rounding: two skins.
constexpr double kMostApart = 5;      // and times what lies between its places relative to them.

constexpr std::uint64_t kNoArrivals = ~std::uint64_t{0};  // Of no scene.

/**
 * Planes so nearly parallel that a skin shifts the line in which they meet tell no more; nor does one that the proxy
 * has left behind, when a tick's sweeps are used up. Out of the way of one plane.
 */
[[gnu::noinline]] void distrustFarPlanes(const Vec3& proxy, double most, Vec3& at, Vec3& foot) HD_RT {
  if ((at - proxy).squaredNorm() > most * most) at = foot = proxy;
}

}  // namespace

void ProxyRenderer::reset(const Vec3& hip_W) HD_RT {
  proxy_ = hip_W;
  object_ = 0;
  rest_.count = 0;
  footing_.object = 0;
  slip_ = false;
  started_ = true;
  behind_ = false;
  pinched_by_ = 0;
  about_.set();
  arrivals_ = kNoArrivals;
}

void ProxyRenderer::step(const Scene& scene, const Vec3& hip_W, const Vec3& v_W, double,
                         SurfaceContact& contact) HD_RT {
  contact = SurfaceContact{};
  contact.proxy = contact.point = proxy_;
  holding_count_ = 0;
  if (!isFinite(hip_W)) {  // What moves meanwhile would be met from where the proxy stood before.
    started_ = false;
    return;
  }
  if (!started_) reset(hip_W);
  Step step;
  step.scene = &scene;
  step.goal = hip_W;
  step.v_W = v_W;
  step.end = step.began = proxy_;
  step.behind = behind_ || !scene.triangleMoves().empty();
  step.scale = std::max(extent(proxy_), extent(hip_W));
  step.slip = step.slipped = slip_;
  surroundings_.tick();
  begin(step);
  const bool deformed = radius_ > 0 && !scene.triangleMoves().empty();
  if (deformed) makeRoom(step);
  step.together = step.together || !step.carried;  // Vertices have moved elsewhere, or a shape changed there.
  if (scene.arrivals() != arrivals_) {
    arrivals_ = scene.arrivals();
    about_.set();
    rest_.count = 0;  // It may have jumped: no motion, and its surface is elsewhere.
    stepOff(step);
  }
  if (deformed || radius_ != wanted_radius_ || (about_.any() && radius_ > 0)) fitRadius(step);
  settleNearer(step);
  if (step.sweeps > kMaxRounds && stepOff(step, true)) [[unlikely]] {  // To and fro between the sides of a sheet.
    step.count = 0;
    step.settled = step.supported = false;
    settleNearer(step);
  }
  if (goAround(step)) {
    step.supported = false;
    settleNearer(step);
  }
  finish(step, v_W, contact);
}

/** Whether the last step left the proxy at a place of its own relative to the object, which has not jumped since. */
bool ProxyRenderer::isBehind(const SceneObject& object, std::uint32_t slot) const HD_RT {
  const Pose &then = start_pose_[slot], &now = object.X_WO_before;
  return behind_ && start_id_[slot] == object.id && then.p == now.p && then.q.coeffs() == now.q.coeffs();
}

/**
 * Whether the object's motion in this tick may have come upon the proxy where it stood. What has moved elsewhere has
 * moved first, and stands: the proxy is swept against it as it is now.
 */
bool ProxyRenderer::mayCarry(const Step& step, const SceneObject& object) const HD_RT {
  if (!object.moved) return false;
  const Vec3 center = object.toLocal(object.center_W);
  const double way = (object.center_W - object.X_WO_before.q * center - object.X_WO_before.p).norm();
  const double reach = object.radius + way + radius_ + kAt * step.skin(object);
  return !((object.center_W - proxy_).squaredNorm() > reach * reach);
}

/** So that the next step goes on from these places. */
void ProxyRenderer::noteStarts(const Step& step) HD_RT {
  start_id_.fill(0);
  for (const std::uint16_t slot : step.scene->touchable()) {
    start_id_[slot] = step.scene->slot(slot).id;
    start_pose_[slot] = step.scene->slot(slot).X_WO;
  }
}

/** Puts the proxy where it was relative to each object, if any has moved where it stands. */
void ProxyRenderer::begin(Step& step) HD_RT {
  const auto touchable = step.scene->touchable();
  const auto moves = step.scene->triangleMoves();
  step.carried = behind_;
  for (const std::uint16_t slot : touchable) step.carried = step.carried || mayCarry(step, step.scene->slot(slot));
  const bool reshaped = isReshaped(step);
  if (!step.carried && moves.empty() && !reshaped) return;
  step.together = false;
  for (const std::uint16_t slot : touchable) {
    const SceneObject& object = step.scene->slot(slot);
    if (object.id == object_) step.carrier = slot;
    if (!isBehind(object, slot)) start_[slot] = object.X_WO_before.q.conjugate() * (proxy_ - object.X_WO_before.p);
    carried_[slot] = start_[slot];
  }
  followVertices(step);
  if (reshaped) followShape(step);
}

/**
 * What is kept of the triangles about the proxy, which stands at `start` in that object's frame; null if nothing is: in
 * free space a sweep meets few boxes anyway.
 */
Vicinity* ProxyRenderer::vicinityOf(Step& step, std::uint32_t slot, const Vec3& start) HD_RT {
  for (int i = 0; i < step.near_count; ++i) {
    if (step.near[i].slot == slot) return step.near[i].vicinity;
  }
  const SceneObject& object = step.scene->slot(slot);
  if (!keep_ || object_ == 0 || object.shape.kind != ShapeKind::kMesh || step.near_count == Surroundings::kMeshes)
    return nullptr;
  ProxyPlace place{start, start, step.hipIn(slot), radius_};
  if (radius_ > 0) place.end += object.R_WO.transpose() * (step.end - proxy_);  // A point swings less.
  Vicinity* const vicinity = surroundings_.about(slot, object.shape, place, step.gathered);
  step.near[step.near_count++] = {slot, vicinity};
  return vicinity;
}

Vec3 ProxyRenderer::startIn(const Step& step, std::uint32_t slot) const HD_RT {
  return step.together ? step.scene->slot(slot).toLocal(proxy_) : start_[slot];
}

/** The proxy in W: carried along by the surface that holds it. */
Vec3 ProxyRenderer::here(const Step& step) const HD_RT {
  if (step.together || step.count == 0) return proxy_;
  const std::uint32_t slot = step.held[step.count - 1].slot;
  return step.scene->slot(slot).toWorld(start_[slot]);
}

/**
 * Sweeps from where the proxy is to `target` against everything. False when the work is used up: then nothing is
 * known and the proxy must not move. `above` as in Sweep, in W. `beside`: what is passed.
 */
bool ProxyRenderer::sweepTo(Step& step, const Vec3& target, const Vec3& above, bool& hit, std::uint32_t& slot,
                            SweepHit& first, Beside beside) HD_RT {
  hit = false;
  if (++step.sweeps > kMaxSweeps) return false;
  first = SweepHit{};
  const Vec3 along = target - proxy_;
  const double along2 = along.squaredNorm();
  for (const std::uint16_t i : step.scene->touchable()) {
    if (i == step.unfelt) [[unlikely]]
      continue;
    const SceneObject& object = step.scene->slot(i);
    if (beside != Beside::kNone && step.passes(i, beside)) continue;
    if (step.back && step.wasAt(object, target)) continue;
    const double skin = step.skin(object);
    if (step.together) {  // A ball that the segment does not reach.
      const Vec3 r = object.center_W - proxy_;
      const double t = along2 > 0 ? std::clamp(r.dot(along) / along2, 0.0, 1.0) : 0.0;
      const double reach = object.radius + radius_ + skin;
      if ((r - t * along).squaredNorm() > reach * reach) continue;
    }
    Sweep sweep;
    sweep.a = startIn(step, i);
    sweep.d = object.toLocal(target) - sweep.a;
    sweep.above = object.R_WO.transpose() * above;
    sweep.radius = radius_;
    sweep.tolerance = kNear * skin;
    sweep.two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
    if (i == hint_slot_) sweep.hint = hint_;
    sweep.vicinity = vicinityOf(step, i, sweep.a);
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
  if (hit && beside == Beside::kNone) {
    hint_slot_ = slot;
    hint_ = first.feature;
  }
  return true;
}

/** Goes the fraction t of the way to `target`. */
void ProxyRenderer::moveBy(Step& step, const Vec3& target, double t) HD_RT {
  if (t <= 0) return;
  step.noteGone();
  if (step.together) {
    proxy_ += t * (target - proxy_);
    return;
  }
  for (const std::uint16_t i : step.scene->touchable()) {
    start_[i] += t * (step.scene->slot(i).toLocal(target) - start_[i]);
  }
  proxy_ += t * (target - proxy_);
}

void ProxyRenderer::arrive(Step& step, const Vec3& target) HD_RT {
  proxy_ = target;
  step.together = true;
  step.noteGone();
}

/** Goes on the way to `target` as far as a skin above the surface met there, also where the way only grazes it. */
void ProxyRenderer::comeTo(Step& step, const Vec3& target, std::uint32_t slot, const SweepHit& first) HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const double approach = -first.normal.dot(object.toLocal(target) - startIn(step, slot));
  moveBy(step, target, std::max(0.0, first.t - step.skin(object) / approach));
}

/** Comes to the surface met on the way to `target`, which holds the proxy from now on. */
void ProxyRenderer::meet(Step& step, const Vec3& target, std::uint32_t slot, const SweepHit& first) HD_RT {
  step.real = false;
  const double skin = step.skin(step.scene->slot(slot));
  const bool judged = step.judged, slipped = step.slipped;
  const Vec3 before = startIn(step, slot);
  if (first.height > 1.5 * skin) comeTo(step, target, slot, first);
  if ((startIn(step, slot) - before).squaredNorm() <= kAt * skin * kAt * skin) {  // It was there.
    step.judged = judged;
    step.slipped = slipped;
  }
  hold(step, slot, first);
}

/** Moves the proxy as far as it goes. */
void ProxyRenderer::settle(Step& step) HD_RT {
  bool hit = false;
  std::uint32_t slot = 0;
  SweepHit first;
  Plan next;
  bool held = step.again = holdAgain(step);
  if (!held) looked_.count = 0;
  double nearest = std::numeric_limits<double>::infinity(), let_go = nearest;
  for (int vain = 0;; held = false) {
    const int last = step.count;
    if (!held) step.count = step.broken = 0;
    const double distance = (proxy_ - step.goal).norm();
    if (!step.together || distance < kClearlyNearer * nearest) {
      nearest = distance;
      vain = 0;
    } else if (++vain > kMaxVain) {
      holdWhereItIs(step);
      return;
    }
    next.goTo(step.goal);
    for (int round = 0;; ++round) {
      if (!held) {
        if (step.together && step.sweeps >= kMaxSweeps - kKeptSweeps) {
          holdWhereItIs(step);
          return;
        }
        if (!sweepTo(step, next.target(), next.above[next.gone], hit, slot, first)) {
          if (step.count == 0) step.count = last;  // What held it before this look: nearly what does now.
          return;
        }
        if (!hit) {
          arrive(step, next.target());
          if (++next.gone < next.parts) continue;
          if (!next.lands) break;
          land(step, next);
          return;
        }
        if (round >= kMaxRounds) {
          if (!step.together) return;
          if ((proxy_ - step.goal).norm() < kClearlyNearer * distance) break;  // It gets on: afresh from here.
          holdWhereItIs(step);
          return;
        }
        if (next.in_groove) ++step.broken;
        if (next.faces > 0) step.seek(next.slot, next.face[0], next.face[1], next.faces);
        meet(step, next.target(), slot, first);
      }
      held = false;
      plan(step, next);
      for (int i = 1; i < kMaxHolding && next.stay && meetBeside(step); ++i) plan(step, next);
      if (next.lands) step.end = next.way[next.parts - 1];
      step.settled = next.stay && step.together;
      if (step.settled) {
        held = letGoOfAbsent(step, let_go);
        if (held) continue;
        if (!leaveVertex(step)) return;
        break;  // What holds it there is met anew.
      }
    }
    if (step.count == 0) return;  // Arrived at the goal.
  }
}

/**
 * No farther from the hip than it is, or than what held it takes it along, unless something else is in the way there:
 * the spring would gain by what has interrupted a way.
 */
void ProxyRenderer::settleNearer(Step& step) HD_RT {
  if (!step.together) [[unlikely]]
    return settleCarried(step);
  const Vec3 from = proxy_;
  settle(step);
  if (leadsAway(from, proxy_, step.goal)) settleAgain(step, from, 0);
}

/** From where it was: one way after the other, for one of several parts has led away. */
void ProxyRenderer::settleAgain(Step& step, const Vec3& from, std::uint32_t slot) HD_RT {
  if (!step.together || !goBack(step, from, slot)) return;
  step.plain = true;
  settle(step);
  if (leadsAway(from, proxy_, step.goal)) (void)goBack(step, from, slot);
}

/** How far its places relative to the objects that hold it are from the proxy. */
double ProxyRenderer::spread(const Step& step) const HD_RT {
  double most = 0;
  for (int i = 0; i < step.count && !step.together; ++i) {
    const std::uint32_t slot = step.held[i].slot;
    most = std::max(most, (step.scene->slot(slot).toWorld(start_[slot]) - proxy_).norm());
  }
  return most;
}

/** The surfaces that hold the proxy against the hip; the proxy's skin above them is not felt. */
const ProxyRenderer::Support& ProxyRenderer::support(Step& step) const HD_RT {
  Support& s = step.support;
  if (step.supported) return s;
  step.supported = true;
  s = Support{};
  HalfSpace exact[kMaxHalfSpaces];
  double rounding = 0;
  for (int i = 0; i < step.count; ++i) {
    exact[i] = step.held[i].surface;
    rounding = std::max(rounding, kNear * step.held[i].skin);
  }
  s.foot = step.goal;
  const bool held = step.count > 0 && nearestInside(exact, step.count, rounding, s.foot, s.active) && s.active != 0;
  // On a two-sided sheet itself, or less than a skin above: the proxy hovers, nothing is felt.
  const bool hovers = !held && step.count > 0 && (proxy_ - step.goal).norm() <= kHovers * rounding;
  s.at = hovers ? step.goal : proxy_;
  if (held && !nearestOnPlanes(exact, s.active, s.at)) s.at = proxy_;
  if (held && ((s.active & (s.active - 1)) != 0 || leadsAway(proxy_, s.at, step.goal))) [[unlikely]]
    distrustFarPlanes(proxy_, kMostBack * rounding + kMostApart * spread(step), s.at, s.foot);
  if (!held) s.foot = s.at;
  s.touching = held || (s.at != step.goal && (step.count > 0 || proxy_ != step.goal));
  if (step.count > 0) step.met = step.held[foremost(step, s.active)].slot;
  return s;
}

/**
 * To where it was before it settled; relative to the object in the slot, if there is one, and then past all others that
 * have moved against that one. False: one of them is in the way.
 */
bool ProxyRenderer::goBack(Step& step, const Vec3& from, std::uint32_t slot) HD_RT {
  if (slot != 0) {
    const int count = step.count;
    const std::uint32_t last = step.held[0].slot;
    step.held[0].slot = slot;
    step.count = 1;
    bool hit = false;
    std::uint32_t other = 0;
    SweepHit first;
    step.back = true;
    const bool free = sweepTo(step, from, Vec3::Zero(), hit, other, first, Beside::kHolders) && !hit;
    step.back = false;
    step.held[0].slot = last;
    step.count = count;
    if (!free) return false;
  }
  arrive(step, from);
  step.count = 0;
  step.settled = step.supported = false;
  return true;
}

void ProxyRenderer::finish(Step& step, const Vec3& v_W, SurfaceContact& contact) HD_RT {
  behind_ = !step.together;
  if (behind_) {
    noteStarts(step);
    proxy_ = here(step);
  }
  contact.work = step.work + step.gathered;
  effort_ = {step.sweeps, step.work, step.gathered, step.turns, step.walked};
  const Support& support = this->support(step);
  std::uint32_t object = step.met != 0 ? step.scene->slot(step.met).id : object_;
  const SceneObject* surface = support.touching ? step.scene->find(object) : nullptr;
  const bool before = object_ != 0;
  if (!surface) {
    rest_.count = 0;
    footing_.object = 0;
    contact.proxy = contact.point = proxy_;
    object_ = 0;
    slip_ = false;
    return;
  }
  const std::uint32_t active = support.active;
  const Vec3 up = support.foot - step.goal;
  contact.friction = frictionOf(step, *surface, active, up);
  contact.proxy = support.at;
  contact.depth = up.norm();
  const Constraint* const on = step.count > 0 ? &step.held[foremost(step, active)] : nullptr;
  const Vec3 out = on ? on->surface.normal : contact.depth > 0 ? Vec3(up / contact.depth) : Vec3::Zero();
  contact.point = support.at - radius_ * out;
  const Press press = pressOf(step, *surface, on ? on->feature : HD_NO_INDEX, active, up, contact.point, &contact);
  contact.normal = contact.smooth = press.normal;
  contact.velocity = press.velocity;
  contact.at_hip = press.at_hip;
  contact.stiffness = press.stiffness;
  contact.damping_gain = press.damping;
  contact.pull = support.at - step.goal + press.turned;
  contact.stored = 0.5 * (press.stiffness * contact.pull.squaredNorm() +
                          (press.stored - press.stiffness) * contact.depth * contact.depth);
  const double elastic = press.stiffness * contact.pull.dot(contact.normal);
  const double approach = contact.normal.dot(contact.at_hip - v_W);
  contact.damping = std::max(press.damping * approach, -elastic);
  contact.force = press.stiffness * contact.pull + contact.damping * contact.normal;
  // Damping takes all of it, and friction with it: then what rounding leaves must not tell a direction.
  if (contact.damping <= -elastic && (support.at - support.foot).norm() <= kAt * kSkin * step.scale)
    contact.force.setZero();
  contact.apart = press.apart + contact.force.cwiseProduct(contact.at_hip - contact.velocity);
  contact.object = object;
  contact.touch = !before;
  noteRest(step, active);
  noteFooting(step, active, contact.friction);
  noteHolding(step, active, up);
  slip_ = step.slip && contact.friction.still > 0;
  left_ = contact.depth > 0 ? (support.at - support.foot).norm() / contact.depth : contact.friction.sliding;
  contact.slip = slip_;
  object_ = object;
  shape_ = surface->shape.number;
}

}  // namespace hapticd
