// A nearer part of the surface, gone to outside of everything solid: docs/rendering.md, "Around the outside".
#include "rt/geometry/triangle.h"
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kOpposed = -0.6;               // Cosine below which two normals are those of two sheets.
constexpr double kSameSide = 0.5;               // Cosine above which the one may be the other, farther along a curve.
constexpr double kNearerThanRest = 1 - 0x1p-6;  // Places on facets of one curve differ by what the edges bend.
constexpr double kMaxDetour = 5;                // Of the present distance from proxy to hip.
constexpr double kUnder = 2;                    // Skins below the surface is surely inside.
constexpr double kRight = -1e-9;                // Cosine of a right angle, less rounding.
constexpr double kClear = 0x1p-3;               // Of the depth: facets of one side are not quite in one plane.

/** Whether the way from the hip to `x`, both in the object's frame, is not all through the solid. */
bool leavesSolid(const SceneObject& object, const Vec3& hip, const Vec3& x, double tolerance, Vicinity* vicinity,
                 std::uint32_t& work) HD_RT {
  Sweep sweep;
  sweep.vicinity = vicinity;
  sweep.a = hip;
  sweep.d = x - hip;
  sweep.tolerance = tolerance;
  sweep.work = work;
  sweep.limit = ProxyRenderer::kMaxWork;
  SweepHit hit;
  const SweepResult result = sweepShape(object.shape, sweep, hit);
  work = sweep.work;
  return result != SweepResult::kNone;
}

/** Whether a ball with its centre at x, in the object's frame, touches the object. */
bool touches(const SceneObject& object, const Vec3& x, double radius, Vicinity* vicinity, std::uint32_t& work) HD_RT {
  Nearest near;
  return nearestWithin(object, x, radius, vicinity, work, near) != NearestResult::kNone;
}

/**
 * Whether the hip is inside the solid of which `near`, among what is turned as asked, is nearest. The edge or vertex of
 * a mesh tells only if nothing that is turned otherwise is nearer: else that does.
 */
bool isInside(const SceneObject& object, const NearestQuery& query, const Nearest& near, std::uint32_t& work) HD_RT {
  Nearest nearest = near;
  if (near.kind != FeatureKind::kFace) {
    (void)nearestWithin(object, query.x, kClearlyNearer * std::sqrt(near.squared_distance), query.vicinity, work,
                        nearest);
  }
  return nearest.isInside(query.x);
}

}  // namespace

/** Follows `way` if it is free and at most `most` long; else the proxy stays. */
bool ProxyRenderer::goVia(Step& step, const Vec3* way, int count, double most) HD_RT {
  double length = (way[0] - proxy_).norm();
  for (int i = 1; i < count; ++i) length += (way[i] - way[i - 1]).norm();
  if (!(length <= most)) return false;
  const Vec3 from = proxy_;
  for (int i = 0; i < count; ++i) {
    bool hit = false;
    std::uint32_t slot = 0;
    SweepHit first;
    const bool known = sweepTo(step, way[i], Vec3::Zero(), hit, slot, first);
    if (!known || hit) {
      proxy_ = from;
      if (!known || step.unfelt != 0 || !isAbout(step, slot)) return false;
      step.unfelt = slot;
      const bool gone = goVia(step, way, count, most);
      step.unfelt = 0;
      return gone;
    }
    proxy_ = way[i];
  }
  return true;
}

/** Goes toward `target`, up to the first surface on the way. */
void ProxyRenderer::goToward(Step& step, const Vec3& target) HD_RT {
  bool hit = false;
  std::uint32_t slot = 0;
  SweepHit first;
  if (target == proxy_ || !sweepTo(step, target, Vec3::Zero(), hit, slot, first)) return;
  if (hit) {
    comeTo(step, target, slot, first);
  } else {
    moveBy(step, target, 1);
  }
}

/**
 * Whether a ball with its centre at x, in the object's frame, touches a triangle that holds the proxy now: told at
 * once, and most places are where the ball does not fit for one of these.
 */
bool ProxyRenderer::touchesHeld(const Step& step, std::uint32_t slot, const Vec3& x, double radius) HD_RT {
  const Shape& shape = step.scene->slot(slot).shape;
  if (shape.kind != ShapeKind::kMesh) return false;
  for (int i = 0; i < step.count; ++i) {
    const Constraint& c = step.held[i];
    if (c.slot != slot) continue;
    if ((nearestOnTriangle(cornersOf(*shape.mesh, c.feature), x).point - x).squaredNorm() < radius * radius)
      return true;
  }
  return false;
}

/**
 * The point of the object nearest to the hip, seen from inside or through less than the ball. Of those that hold the
 * proxy, held[i] is one; of another one the hip must be inside. False: there is none that is nearer.
 */
bool ProxyRenderer::nearerOn(Step& step, const Support& now, std::uint32_t slot, int i, Nearer& best) const HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const Constraint& c = step.held[i];
  const double mu = frictionOf(step, step.scene->slot(c.slot), now.active, now.foot - step.goal).still;
  NearestQuery query;
  query.x = step.hipIn(slot);
  // With friction: nearer by more than the cone can account for. From the air before a surface on which the ball is
  // less deep that may be farther than from inside.
  const double cone = mu > 0 ? std::sqrt(1 + mu * mu) : 1.0, present = kClearlyNearer * (now.at - step.goal).norm();
  query.reach = (radius_ > 0 ? present : present / cone) - radius_;
  if (!(query.reach > 0)) return false;
  query.turned = true;
  query.axis = object.R_WO.transpose() * (now.foot - step.goal).normalized();
  query.cosine = kOpposed;
  query.vicinity = step.vicinity(slot);
  query.work = step.work;
  query.limit = kMaxWork;
  Nearest near;
  const NearestResult result = nearestOnShape(object.shape, query, near);
  step.work = query.work;
  if (result != NearestResult::kFound) return false;
  // A hip in the air, for which the ball is too thick, is as far outside as it is not deep.
  const double skin = step.skin(object), distance = std::sqrt(near.squared_distance);
  const bool inside = isInside(object, query, near, step.work);
  const double depth = radius_ + (inside ? distance : -distance);
  // Who is in the air beside an edge is nearest to the ball that touches it on his side.
  const bool beside = !inside && near.kind != FeatureKind::kFace && distance > kDirected * skin;
  const Vec3 up = beside ? Vec3((query.x - near.point) / distance) : near.pseudo_normal;
  if (!(depth < present / cone) || (!inside && (radius_ == 0 || c.slot != slot))) return false;
  // Above all facets of a side that is not quite plane, or of solids side by side, but nearer to the hip than now.
  const double above = std::min(kClear * (now.foot - step.goal).norm(), 0.5 * (present - depth)) + skin;
  if (radius_ > 0 && touchesHeld(step, slot, near.point + (radius_ + above) * up, radius_ + 0.5 * skin)) return false;
  // But nothing else may be nearer to it, such as the far side of the sheet on which the ball rests.
  if (!inside && touches(object, query.x, kClearlyNearer * distance, query.vicinity, step.work)) return false;
  // Friction alone keeps the proxy from where it would come to without: on a curve farther than its cone is wide.
  if (mu > 0 && (object.R_WO * up).dot(c.surface.normal) > kSameSide) {
    const double at_rest = depthAtRest(step, i);
    if (at_rest > 0 && kNearerThanRest * at_rest <= depth) return false;
  }
  // From inside to inside, for along a side whose facets are not quite in one plane no way stays below them all.
  const Vec3 &out = c.surface.normal, held = object.toLocal(now.at - radius_ * out);
  const double below = std::max(kUnder * skin, kClear * (held - near.point).norm());
  const Vec3 from = inside && distance > below ? query.x : Vec3(near.point - below * near.pseudo_normal);
  if (leavesSolid(object, from, held - object.R_WO.transpose() * (below * out), kNear * skin, query.vicinity,
                  step.work))
    return false;
  best = {slot, object.toWorld(near.point), object.R_WO * up, depth, above};
  return true;
}

/** Whether the proxy is in the solid: that has appeared about it, and is not felt until it has been left. */
bool ProxyRenderer::isWithin(Step& step, std::uint32_t slot) const HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const Vec3 x = object.toLocal(proxy_);
  const double skin = step.skin(object);
  Nearest near;
  const NearestResult result = nearestWithin(object, x, kAnyLength, step.vicinity(slot), step.work, near);
  if (result == NearestResult::kExhausted) return true;
  return result == NearestResult::kFound && near.isInside(x) && near.squared_distance > kAt * skin * kAt * skin;
}

/**
 * Whether a primitive, of one part and without a hollow, has appeared about the proxy: who is in it before and after a
 * way has passed nothing.
 */
bool ProxyRenderer::isAbout(Step& step, std::uint32_t slot) const HD_RT {
  return step.scene->slot(slot).shape.kind != ShapeKind::kMesh && !step.isHeldBy(slot) && isWithin(step, slot);
}

/**
 * Goes to a nearer part of the surface if a free way leads there; of several solids in which the hip is, to the nearest
 * to which one does. True if the proxy moved.
 */
bool ProxyRenderer::goAround(Step& step) HD_RT {
  if (!step.together || step.count == 0) return false;
  const Support& now = support(step);
  if (now.active == 0 || now.foot == step.goal) return false;
  Nearer place[kMaxHalfSpaces];
  int count = 0;
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    if ((object.flags & HD_OBJECT_TWO_SIDED) != 0 || object.shape.kind == ShapeKind::kPlane) continue;
    int by = 0;
    while (by < step.count && !((now.active >> by & 1u) && step.held[by].slot == slot)) ++by;
    if (by == step.count) {
      if (!((object.center_W - step.goal).squaredNorm() < object.radius * object.radius)) continue;
      by = std::countr_zero(now.active);
    }
    Nearer found;
    if (!nearerOn(step, now, slot, by, found) || (!step.isHeldBy(slot) && isWithin(step, slot))) continue;
    if (count == kMaxHalfSpaces && found.depth >= place[count - 1].depth) continue;
    int at = std::min(count, kMaxHalfSpaces - 1);  // The nearest few, in order.
    count = at + 1;
    for (; at > 0 && found.depth < place[at - 1].depth; --at) place[at] = place[at - 1];
    place[at] = found;
  }
  for (int i = 0; i < count; ++i)
    if (goAroundTo(step, now, place[i])) return true;
  return false;
}

/** Goes there if a free way leads there. */
bool ProxyRenderer::goAroundTo(Step& step, const Support& now, const Nearer& nearer) HD_RT {
  const SceneObject& object = step.scene->slot(nearer.slot);
  const double skin = step.skin(object);
  const Vec3& n = nearer.normal;
  const Vec3 landing = nearer.point + (radius_ + nearer.above) * n;
  // Where the ball does not fit no way leads, and most that are looked for end there.
  if (radius_ > 0 &&
      touches(object, object.toLocal(landing), radius_ + 0.5 * skin, step.vicinity(nearer.slot), step.work))
    return false;
  const double most = kMaxDetour * (now.at - step.goal).norm();
  const Vec3 from = proxy_;

  // Clear of the edge in which the tangent planes meet; or over what stands between two places that face alike.
  const double depth = (now.foot - step.goal).norm(), clear = kClear * depth;
  HalfSpace planes[kMaxHalfSpaces];
  int count = 0;
  bool rises = true;
  for (int i = 0; i < step.count && count < kMaxHalfSpaces - 1; ++i) {
    if (!(now.active >> i & 1u)) continue;
    rises = rises && step.held[i].surface.normal.dot(n) >= kRight;
    planes[count] = step.held[i].surface;
    planes[count++].offset += step.held[i].skin + clear;
  }
  planes[count] = {n, n.dot(landing) + clear};
  Vec3 edge = step.goal;
  std::uint32_t mask = 0;
  const bool meet = nearestInside(planes, count + 1, kNear * skin, edge, mask) && (mask >> count) == 1;
  const double lift = (most - (landing - proxy_).norm()) / 2;  // As long as that: not asked again, for rounding.
  const Vec3 over[] = {edge, landing}, arch[] = {proxy_ + lift * n, landing + lift * n, landing};
  if (!(meet && goVia(step, over, 2, most)) && !(rises && lift > 0 && goVia(step, arch, 3, kAnyLength))) return false;

  // Friction comes along: the proxy is as far behind, in parts of the depth, and turned as the surface is.
  const Vec3 up = (now.foot - step.goal) / depth, lag = now.at - now.foot;
  const Vec3 turned = lag - (lag.dot(n) / (1 + up.dot(n))) * (up + n);
  if (lag.squaredNorm() > kAt * skin * kAt * skin) goToward(step, nearer.point + (radius_ + skin) * n);
  const Vec3 behind = proxy_ + nearer.depth / depth * turned;
  if (!leadsAway(from, behind, step.goal)) goToward(step, behind);  // About an edge it may, and gives the spring.
  return true;
}

}  // namespace hapticd
