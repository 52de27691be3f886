#include "rt/effect/object_effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rt/effect/drags.h"
#include "rt/effect/path.h"
#include "rt/effect/well.h"
#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/sweep/sweep.h"

namespace hapticd {
namespace {

constexpr double kOnIt = 1e-12;   ///< A hand so near to a surface has no way to it [m].
constexpr double kBeyond = 1.01;  ///< Of the way to the side of a box: out of it.

/** 1 until the effect ends, then falling to 0 within kBlend. */
double lasting(std::int64_t until_ns, std::int64_t now_ns) HD_RT {
  if (until_ns == 0 || now_ns <= until_ns) return 1;
  return std::max(0.0, 1 - static_cast<double>(now_ns - until_ns) * 1e-9 / ObjectEffects::kBlend);
}

/** sin of the turns since the clock's zero: a replay, and every servo, has the same. */
double swing(double frequency, std::int64_t now_ns) HD_RT {
  const double turns = std::fmod(static_cast<double>(now_ns), 1e9 / frequency) * 1e-9 * frequency;
  return std::sin(2 * std::numbers::pi * turns);
}

/** What a field that knows neither past nor motion does in full, in its object's frame. */
Vec3 fieldOf(const EffectParameters& effect, std::int64_t now_ns) HD_RT {
  switch (static_cast<EffectKind>(effect.kind)) {
    case EffectKind::kForce:
      return {0, 0, effect.force};
    case EffectKind::kVibration:
      return {0, 0, effect.frequency > 0 ? effect.force * swing(effect.frequency, now_ns) : 0};
    default:
      return Vec3::Zero();
  }
}

/** A solid that can be touched holds the hand itself; a sheet has no inside. */
bool holdsInside(const SceneObject& object) HD_RT {
  const Shape& shape = object.shape;
  if (shape.kind == ShapeKind::kMesh && (shape.mesh == nullptr || (shape.mesh->flags & HD_MESH_CLOSED) == 0))
    return false;
  return (object.flags & HD_OBJECT_ENABLED) != 0 && (object.flags & HD_OBJECT_TWO_SIDED) == 0;
}

/**
 * Whether x is in a closed mesh, where its surface may be beyond any reach: the shortest way out of the box about it
 * meets the inner side of a triangle first. `work`, in and out, as in Sweep.
 */
bool isWithin(const MeshView& mesh, const Vec3& x, std::uint32_t limit, std::uint32_t& work) HD_RT {
  if (mesh.node_count == 0) return false;
  const hd_bvh_node& root = mesh.nodes[0];
  double least = std::numeric_limits<double>::infinity();
  Vec3 out = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double lower = *std::min_element(root.lower[i], root.lower[i] + root.used);
    const double upper = *std::max_element(root.upper[i], root.upper[i] + root.used);
    if (!(x[i] > lower && x[i] < upper)) return false;
    const double way = x[i] - lower < upper - x[i] ? lower - x[i] : upper - x[i];
    if (!(std::abs(way) < least)) continue;
    least = std::abs(way);
    out = least * Vec3(0.0137, 0.0071, 0.0213);  // Aslant: in modelled meshes edges lie straight before each other.
    out[i] = kBeyond * way;
  }
  Sweep sweep;
  sweep.a = x;
  sweep.d = out;
  sweep.two_sided = true;
  sweep.work = work;
  sweep.limit = limit;
  SweepHit hit;
  const SweepResult result = sweepMesh(mesh, sweep, hit);
  work = sweep.work;
  return result == SweepResult::kHit && faceNormal(mesh, hit.feature).dot(out) > 0;
}

}  // namespace

void ObjectEffects::reset() HD_RT {
  anchor_.fill({});
  fresh_ = true;
  left_ = most_ = 0;
  last_rest_ = Vec3::Zero();
}

/** False: out of reach. */
bool ObjectEffects::find(const SceneObject& object, const EffectParameters& effect, const Vec3& x, int most_visits,
                         Place& place) HD_RT {
  const bool guide = effect.kind == static_cast<std::uint32_t>(EffectKind::kGuide);
  if (effect.points > 1) {
    PathPlace nearest;
    if (!nearestOnPath(effect, x, effect.reach, nearest)) return false;
    place.way = nearest.point - x;
    place.across -= nearest.tangent * nearest.tangent.transpose();
  } else if (object.shape.kind == ShapeKind::kGroup) {
    place.way = -x;
  } else {
    NearestQuery query;
    query.x = x;
    query.limit = static_cast<std::uint32_t>(most_visits);
    query.nearly = true;
    const bool mesh = object.shape.kind == ShapeKind::kMesh;
    // A field fills its solid at any depth, and so does the guide of a solid that holds the hand inside.
    const bool fills = guide ? holdsInside(object) : !mesh;
    if (mesh || !fills) query.reach = effect.reach;
    Nearest nearest;
    const NearestResult result = nearestOnShape(object.shape, query, nearest);
    const bool found = result == NearestResult::kFound;
    const bool deep = !found && mesh && fills && isWithin(*object.shape.mesh, x, query.limit, query.work);
    place.visits = static_cast<int>(query.work);
    if (!found) return deep;
    if (fills && nearest.isInside(x)) return true;
    place.way = nearest.point - x;
    const double distance = place.way.norm();
    const Vec3 n = distance > kOnIt ? Vec3(place.way / distance) : nearest.normal;
    place.across = n * n.transpose();
  }
  place.distance = place.way.norm();
  return place.distance < effect.reach;
}

/**
 * A spring whose end is dragged along once it is stretched to all that friction can be (Hayward and Armstrong, ICRA
 * 2000): no drift at rest, and what it stores never grows but by what the hand puts in.
 */
Vec3 ObjectEffects::friction(Anchor& anchor, std::uint32_t object, const EffectParameters& effect, const Vec3& x,
                             double share) const HD_RT {
  if (anchor.object != object || anchor.step + 1 != steps_) anchor = {object, steps_, x};
  anchor.step = steps_;
  if (!(effect.stiffness > 0)) return Vec3::Zero();
  anchor.at = x + clampNorm(anchor.at - x, share * effect.force / effect.stiffness);
  return effect.stiffness * (anchor.at - x);
}

ObjectEffects::Felt ObjectEffects::feel(const Scene& scene, const Hand& hand, bool before) HD_RT {
  Felt out;
  Drags drags;
  struct {
    Vec3 pull = Vec3::Zero(), v = Vec3::Zero();
    double damping = 0, most = 0;
  } guided;
  double deepest = 0, guides = 0;
  int visits = 0;
  auto to_come = static_cast<int>(scene.effects().size());
  for (const std::uint32_t slot : scene.effects()) {
    const EffectParameters& effect = scene.effect(slot);
    const SceneObject& object = scene.slot(slot);
    const Pose X_WO = before ? scene.onItsWayBefore(slot) : object.X_WO;
    const Mat3 R_WO = before ? X_WO.q.toRotationMatrix() : object.R_WO;
    const Vec3 x = R_WO.transpose() * (hand.p - X_WO.p);
    const double lasts = lasting(effect.until_ns, hand.now_ns);
    out.ends = out.ends || (slot == guide_ && lasts < 1);
    Place place;
    --to_come;
    const int left = std::clamp(kMostVisitsOfAll - visits - kLeastVisits * to_come, kLeastVisits, kMostVisits);
    const bool found = lasts > 0 && find(object, effect, x, left, place);
    visits += place.visits;
    if (!found) continue;
    const double share = lasts * withinReach(place.distance, effect.reach);
    const Vec3 v_O = R_WO.transpose() * (hand.v - object.velocityAt(hand.p));
    if (effect.kind != static_cast<std::uint32_t>(EffectKind::kGuide)) out.most += share * effect.force;
    if (effect.kind == static_cast<std::uint32_t>(EffectKind::kFriction)) {
      Anchor anchor = anchor_[slot];
      out.force += R_WO * friction(anchor, object.id, effect, x, share);
      if (!before) anchor_[slot] = anchor;
    } else if (effect.kind == static_cast<std::uint32_t>(EffectKind::kViscous)) {
      drags.add(R_WO * v_O, share * effect.damping, share * effect.force);
    } else if (effect.kind != static_cast<std::uint32_t>(EffectKind::kGuide)) {
      out.force += R_WO * (share * fieldOf(effect, hand.now_ns));
    } else {
      const Well well(effect.stiffness, effect.force, effect.reach);
      const double depth = lasts * well.depth(place.distance);
      if (!(depth > deepest)) continue;
      deepest = depth;
      out.guide = slot;
      const double pull = lasts * well.pull(place.distance);
      // It damps not more than it pulls: where a solid that can be touched takes over, the force does not jump.
      guided = {Vec3::Zero(), R_WO * (place.across * v_O), share * effect.damping, pull};
      guides = share * effect.force * (effect.damping > 0 ? 2 : 1);
      if (pull > 0) guided.pull = R_WO * (pull / place.distance * place.way);
    }
  }
  drags.add(guided.v, guided.damping, guided.most);
  out.force += guided.pull + drags.force(hand.max_damping);
  out.damping = drags.damping(hand.max_damping);
  out.most += guides;
  visits_ += visits;
  return out;
}

/**
 * What new orders change is what they would have done to the hand as it was a tick ago. Where the force of that tick
 * itself faded into that of this one, a program that ordered something in every tick delayed all of it by 19 ms: the
 * springs that the hand moved against, too. What fades is added up over orders: a guide that follows the hand in every
 * tick is felt where it was 20 ms ago, and no more strongly than the effects of that time may push. One that is put
 * from place to place comes over the time between its poses: a line from one to the next.
 */
Vec3 ObjectEffects::step(const Scene& scene, const Vec3& p, const Vec3& v, double dt, std::int64_t now_ns) HD_RT {
  const Hand hand{p, v, now_ns, max_damping_};
  const bool changed = !fresh_ && scene.effectChanges() != changes_, put = !fresh_ && scene.putOver() > 0;
  const bool ordered = changed || put;
  ++steps_;
  visits_ = 0;
  const Vec3 ordered_before = ordered ? feel(scene, hand_, true).force : Vec3::Zero();
  const Felt felt = feel(scene, hand, false);
  damping_ = felt.damping;
  const bool hands_over = !fresh_ && felt.ends && felt.guide != 0 && felt.guide != guide_;
  if (ordered || hands_over) {
    rest_ = last_rest_ + last_ - (hands_over ? felt.force : ordered_before);
    left_ = blend_ = changed || hands_over ? kBlend : std::max(left_, scene.putOver());
  }
  fresh_ = false;
  hand_ = hand;
  guide_ = felt.guide;
  changes_ = scene.effectChanges();
  left_ = std::max(0.0, left_ - dt);
  last_ = felt.force;
  most_ = left_ > 0 ? std::max(most_, felt.most) : felt.most;
  Vec3 force = left_ > 0 ? clampNorm(last_ + left_ / blend_ * rest_, most_) : last_;
  last_rest_ = force - last_;
  return force;
}

}  // namespace hapticd
