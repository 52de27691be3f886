// Which surfaces hold the proxy, and where they and friction let it go.
#include <bit>

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"
#include "rt/render/friction_cone.h"
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kLate = 16;  // Sweeps after which kSettledLate holds.
constexpr double kOnFace = 8;        // Skins, twice the height by which a ball on an edge rolls off a face.
constexpr int kMaxBroken = 2;        // Ways above a groove; then along the planes, lest one is lost in the air.
constexpr double kTurnCosine = 0.6, kTurnSine = 0.8;  // and so far if it must turn farther.
constexpr double kFarAway = 1000;                     // Of an object's radius.

/** The point nearest to x of the edge, drawn out, or of the vertex that a ball touches at `point`. */
Vec3 footOnRim(const Shape& shape, FeatureKind kind, std::uint32_t feature, std::uint32_t corner, const Vec3& point,
               const Vec3& x) HD_RT {
  if (kind == FeatureKind::kVertex) return point;
  if (shape.kind == ShapeKind::kMesh) {
    const Vec3 a = shape.mesh->vertex(feature, corner);
    const Vec3 along = shape.mesh->vertex(feature, (corner + 1) % 3) - a;
    return a + (x - a).dot(along) / along.squaredNorm() * along;
  }
  Vec3 foot = point;
  if (shape.kind == ShapeKind::kCylinder) {
    const double out = x.head<2>().norm();
    if (out > 0) foot.head<2>() = shape.size.x() / out * x.head<2>();
    return foot;
  }
  int along = 0;  // Of a box's edge: where the point is not at the border.
  (shape.size - point.cwiseAbs()).maxCoeff(&along);
  foot[along] = x[along];
  return foot;
}

/**
 * The face of a box or cylinder that a ball comes to which rolls toward x over the edge that it touches at `point`,
 * numbered as in SweepHit, and its plane. False if it stays on the edge.
 */
[[gnu::noinline]] bool faceBeyondRim(const Shape& shape, const Vec3& point, const Vec3& x, std::uint32_t& feature,
                                     Vec3& normal, double& offset) HD_RT {
  int axis = 2;
  if (shape.kind == ShapeKind::kCylinder) {
    const double beside = x.head<2>().norm() - shape.size.x();
    const double over = std::copysign(1.0, point.z()) * x.z() - shape.size.y();
    if (!(std::min(beside, over) < 0)) return false;
    feature = beside >= over ? 0 : (point.z() > 0 ? 1 : 2);
    if (feature == 0) return tangentNearest(shape, 0, x, normal, offset);
    offset = shape.size.y();
  } else {
    int along = 0;
    (shape.size - point.cwiseAbs()).maxCoeff(&along);
    const int one = (along + 1) % 3, other = (along + 2) % 3;
    const Vec3 height = x.cwiseProduct(point.cwiseSign()) - shape.size;
    if (!(std::min(height[one], height[other]) < 0)) return false;
    axis = height[one] >= height[other] ? one : other;
    feature = static_cast<std::uint32_t>(2 * axis + (point[axis] > 0 ? 0 : 1));
    offset = shape.size[axis];
  }
  normal = std::copysign(1.0, point[axis]) * Vec3::Unit(axis);
  return true;
}

/** Whether x is above or below the triangle's face, seen from its edge that begins at `corner` and passes `foot`. */
bool isOverFace(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& normal,
                const Vec3& x) HD_RT {
  const Vec3 a = mesh.vertex(triangle, corner), along = mesh.vertex(triangle, (corner + 1) % 3) - a;
  return normal.cross(along).dot(x - a) > 0;
}

/** Of the active planes the one below which the goal lies deepest: not the first met, so that order decides nothing. */
int deepest(const HalfSpace* planes, std::uint32_t active, const Vec3& goal) HD_RT {
  int deepest = std::countr_zero(active);
  for (std::uint32_t others = active & (active - 1); others != 0; others &= others - 1) {
    const int i = std::countr_zero(others);
    if (planes[i].height(goal) < planes[deepest].height(goal)) deepest = i;
  }
  return deepest;
}

double settled(std::uint32_t sweeps) HD_RT { return sweeps < kLate ? kSettled : kSettledLate; }

}  // namespace

std::uint32_t faceBeyondEdge(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& x,
                             Vec3& normal) HD_RT {
  const std::uint32_t across = mesh.neighbours != nullptr ? mesh.neighbours[triangle][corner] : HD_NO_INDEX;
  if (across == HD_NO_INDEX) return HD_NO_INDEX;
  std::uint32_t back = 0;
  while (back < 2 && mesh.neighbours[across][back] != triangle) ++back;
  const Vec3 here = faceNormal(mesh, triangle), there = faceNormal(mesh, across);
  const bool over_here = isOverFace(mesh, triangle, corner, here, x);
  const bool over_there = isOverFace(mesh, across, back, there, x);
  if (!over_here && !over_there) return HD_NO_INDEX;
  const Vec3 a = mesh.vertex(triangle, corner);
  const bool takes_here = over_here && (!over_there || here.dot(x - a) >= there.dot(x - a));
  normal = takes_here ? here : there;
  return takes_here ? triangle : across;
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
  met.kind = hit.kind;
  met.corner = hit.corner;
  met.point = hit.point;
  met.surface.normal = object.R_WO * hit.normal;
  met.surface.offset = hit.offset + met.surface.normal.dot(object.X_WO.p);
  met.skin = step.skin(object);
  bool on_face = false;  // Held by that face already: what stops the ball now is the edge itself.
  for (int i = 0; i < step.count; ++i) {
    const Constraint& c = step.held[i];
    on_face = on_face || (c.slot == slot && c.feature == hit.feature && c.kind == FeatureKind::kFace);
  }
  if (hit.kind != FeatureKind::kFace && object.shape.kind == ShapeKind::kMesh && !on_face) {
    // On an edge, but within the skin on the face too: the face's plane does not turn from tick to tick.
    Vec3 face = object.R_WO * faceNormal(*object.shape.mesh, hit.feature);
    if (face.dot(met.surface.normal) < 0) face = -face;
    if ((face - met.surface.normal).squaredNorm() * radius_ < kOnFace * met.skin) {
      met.kind = FeatureKind::kFace;
      met.corner = 0;
      met.surface.normal = face;
      met.surface.offset = face.dot(object.toWorld(object.shape.mesh->vertex(hit.feature, 0))) + radius_;
    }
  }
  int kept = 0;
  for (int i = 0; i < step.count; ++i) {
    const Constraint& c = step.held[i];
    if (c.slot == met.slot && c.feature == met.feature && c.kind == met.kind && c.corner == met.corner) continue;
    const Vec3 x = step.together ? proxy_ : Vec3(step.scene->slot(c.slot).toWorld(start_[c.slot]));
    // Below it, and yet outside: passed on the way around, and no wall from here.
    if (std::abs(c.surface.height(x)) <= 2 * c.skin && kept < kMaxHalfSpaces - 1) step.held[kept++] = c;
  }
  step.held[kept] = met;
  step.count = kept + 1;
  step.again = false;
}

/**
 * What holds the proxy of a curved surface near x, its tangent plane grown by the radius; of a mesh's edge, where x is
 * beyond it, the face to which it leads. x is in the object's frame.
 */
bool ProxyRenderer::tangentTo(const SceneObject& object, const Constraint& c, const Vec3& x,
                              Constraint& there) const HD_RT {
  there = c;
  Vec3 normal;
  double offset = 0;
  if (!tangentIn(object, there, x, normal, offset)) return false;
  there.surface.normal = object.R_WO * normal;
  there.surface.offset = offset + there.surface.normal.dot(object.X_WO.p);
  return true;
}

/** The same, its plane in the object's frame. */
bool ProxyRenderer::tangentIn(const SceneObject& object, Constraint& c, const Vec3& x, Vec3& normal,
                              double& offset) const HD_RT {
  if (c.kind == FeatureKind::kFace) return tangentNearest(object.shape, c.feature, x, normal, offset, radius_);
  const bool one_sided_edge = object.shape.kind == ShapeKind::kMesh && c.kind == FeatureKind::kEdge &&
                              (object.flags & HD_OBJECT_TWO_SIDED) == 0;
  const std::uint32_t beyond =
      one_sided_edge ? faceBeyondEdge(*object.shape.mesh, c.feature, c.corner, x, normal) : HD_NO_INDEX;
  if (beyond != HD_NO_INDEX) {
    offset = normal.dot(object.shape.mesh->vertex(beyond, 0)) + radius_;
    c.feature = beyond;
    c.kind = FeatureKind::kFace;
    c.corner = 0;
    return true;
  }
  std::uint32_t face = 0;
  if (c.kind == FeatureKind::kEdge && object.shape.kind != ShapeKind::kMesh &&
      faceBeyondRim(object.shape, c.point, x, face, normal, offset)) {
    offset += radius_;
    c.feature = face;
    c.kind = FeatureKind::kFace;
    return true;
  }
  normal = x - footOnRim(object.shape, c.kind, c.feature, c.corner, c.point, x);
  const double length = normal.norm();
  if (!(length > 0)) return false;
  normal /= length;
  offset = normal.dot(x) - length + radius_;
  return true;
}

/** Whether the foot of x lies between the ends of the edge of a mesh, and x over neither of its faces. */
bool ProxyRenderer::isOnEdge(const SceneObject& object, const Constraint& c, const Vec3& x) HD_RT {
  if (c.kind != FeatureKind::kEdge || object.shape.kind != ShapeKind::kMesh) return false;
  const MeshView& mesh = *object.shape.mesh;
  const Vec3 a = mesh.vertex(c.feature, static_cast<int>(c.corner));
  const Vec3 along = mesh.vertex(c.feature, static_cast<int>(c.corner + 1) % 3) - a;
  const double foot = (x - a).dot(along);
  Vec3 normal;
  return foot > 0 && foot < along.squaredNorm() && faceBeyondEdge(mesh, c.feature, c.corner, x, normal) == HD_NO_INDEX;
}

/**
 * Whether the foot of x lies on the feature of a mesh itself, not just on its plane or line drawn out; of an edge or
 * vertex of an open sheet only where it stops a ball: from its front.
 */
bool ProxyRenderer::isOnFeature(const SceneObject& object, const Constraint& c, const Vec3& x) HD_RT {
  if (object.shape.kind != ShapeKind::kMesh) return false;
  const MeshView& mesh = *object.shape.mesh;
  if (c.kind != FeatureKind::kFace) {
    if (c.kind == FeatureKind::kEdge && !isOnEdge(object, c, x)) return false;
    if ((mesh.flags & HD_MESH_CLOSED) != 0 || (object.flags & HD_OBJECT_TWO_SIDED) != 0) return true;
    std::uint32_t work = 0;
    const Vec3 rim = mesh.vertex(c.feature, static_cast<int>(c.corner));
    return pseudoNormal(mesh, c.feature, c.kind, c.corner, work).dot(x - rim) >= 0;
  }
  return nearestOnTriangle(cornersOf(mesh, c.feature), x).kind == FeatureKind::kFace;
}

/** On a single curved surface: over the edge of two tangent planes to the point nearest to the goal. */
bool ProxyRenderer::planOnCurve(Step& step, const Vec3& here, Plan& plan) HD_RT {
  const Constraint& c = step.held[0];
  const SceneObject& object = step.scene->slot(c.slot);
  Constraint& there = step.held[1];
  if (c.kind == FeatureKind::kFace && !isCurved(object.shape, c.feature)) return false;
  if (!tangentTo(object, c, step.hipIn(c.slot), there)) return false;
  const double cosine = there.surface.normal.dot(c.surface.normal);
  const bool far = cosine < kMaxTurnCosine;
  if (far) {  // A part of the way round, and again from there: to what is seen from far away in that direction.
    const Vec3 side = there.surface.normal - cosine * c.surface.normal;
    const double sine = side.norm();
    if (!(sine > 0)) return false;
    const Vec3 toward = kTurnCosine * c.surface.normal + kTurnSine / sine * side;
    if (!tangentTo(object, c, object.toLocal(here + kFarAway * object.radius * toward), there)) return false;
    if (there.surface.normal.dot(c.surface.normal) < kMaxTurnCosine) return false;
  }
  const HalfSpace planes[2] = {{c.surface.normal, c.surface.offset + c.skin},
                               {there.surface.normal, there.surface.offset + c.skin}};
  Vec3 last = step.goal;
  if (!nearestOnPlanes(planes, 2, last)) return false;
  Vec3 over = last;
  if (!nearestOnPlanes(planes, 3, over)) return false;
  if ((last - here).norm() <= std::max(c.skin, settled(step.sweeps) * (last - step.goal).norm())) return false;
  // But round the middle of a curved surface the way may lead away at first.
  const bool round = far && c.kind == FeatureKind::kFace;
  if (!round && step.together && leadsAway(here, last, step.goal)) return false;
  plan.goTo(over);
  plan.way[plan.parts++] = last;
  plan.above[0] = planes[0].normal;
  plan.above[1] = planes[1].normal;
  // Above the plane there it is free to go on: it would hang on it, and be pulled.
  plan.lands = !far && there.surface.height(step.goal) < 0 && isOnFeature(object, there, object.toLocal(last));
  plan.keeps = 2;
  return true;
}

/** Where the surfaces that hold the proxy, and friction, let it go. */
void ProxyRenderer::plan(Step& step, Plan& plan) HD_RT {
  Vec3 at = here(step);
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
    plan.goTo(at);
    plan.stay = true;
    return;
  }
  // Not yet at one place relative to all objects: friction knows it as the nearest that suits those that hold it.
  std::uint32_t holding = 0;
  if (!step.together && !nearestInside(above, step.count, kNear * skin, at, holding)) at = foot;
  const double rest = std::max(kNear * skin, settled(step.sweeps) * (foot - step.goal).norm());
  const Constraint& first = step.held[foremost(step, active)];
  const SceneObject& surface = step.scene->slot(first.slot);
  const bool may_bend = !step.plain && step.broken < kMaxBroken && step.count <= kMaxInGroove;
  Friction friction = frictionOf(step, surface, active, foot - step.goal);
  if (friction.still > 0) {
    Vec3 on_surface = step.goal;
    if (!nearestOnPlanes(exact, active, on_surface)) on_surface = foot;
    const Vec3 lag = at - foot;
    const double r = lag.norm(), d = (on_surface - step.goal).norm();
    double left = 1, stiffness = surface.material.stiffness;
    Vec3 eased = Vec3::Zero();
    if (d > 0 && (surface.material.damping > 0 || !isOneBit(active))) {
      // What damping leaves of the elastic force where the surface goes away from the hand: the cone is that of the
      // rest.
      const Press press = pressOf(step, surface, first.feature, active, on_surface - step.goal, at);
      stiffness = press.stiffness;
      const double approach = std::min(0.0, press.normal.dot(press.at_hip - step.v_W));
      if (press.damping > 0) {
        left = std::max(0.0, 1 + press.damping * approach / (press.stiffness * d));
        eased = press.damping / press.stiffness * (step.v_W - press.at_hip);
      }
    }
    if (load_.moment > 0) shareFriction(step, stiffness, r, left * d, friction);
    step.slip = step.slipped;  // Surfaces that it meets where it is hold it together: none decides alone.
    if (!step.judged) {
      step.asked = true;
      step.slip = slip_ && r >= slipEnds(left_, left * friction.sliding, d, resolution_);
    }
    const double sliding = left * friction.sliding;
    const double cone = (step.slip ? sliding : left * friction.still) * d;
    if (r <= cone * (1 + kConeRounding)) {
      plan.goTo(at);
      plan.stay = true;
      return;
    }
    const bool breaks_away = !step.slip;
    step.slip = true;
    plan.goTo(foot + lag * (sliding * d / r));
    plan.stay = (plan.way[0] - at).norm() <= rest;
    if (active != 0) plan.above[0] = exact[std::countr_zero(active)].normal;
    if (!plan.stay && step.count == 1 && slideOnCurve(step, at, sliding, rest, plan)) return;
    if (!plan.stay && may_bend && !isOneBit(active) && !step.isHeldByFaces() &&
        planInGroove(step, at, sliding, rest, plan))
      return;
    // What breaks away goes straight: in a hollow the other face is there, and may hold it yet.
    if (!plan.stay && !breaks_away && isOneBit(active))
      (void)followFaces(step, std::countr_zero(active), at, friction.sliding, eased, plan);
    return;
  }
  const bool tried = may_bend && step.sought_count > 0;
  if (tried && planInGroove(step, at, 0, rest, plan)) return;
  step.sought_count = 0;
  if (step.count == 1) {
    if (step.held[0].kind == FeatureKind::kEdge && followFaces(step, 0, at, 0, Vec3::Zero(), plan)) return;
    if (may_bend && !tried && step.sought_count > 0 && planInGroove(step, at, 0, rest, plan)) return;
    if (!step.plain && planOnCurve(step, at, plan)) return;
  } else if (may_bend && !step.isHeldByFaces() && planInGroove(step, at, 0, rest, plan)) {
    return;
  }
  plan.goTo(foot);
  plan.stay = (foot - at).norm() <= rest;
  if (active != 0) plan.above[0] = exact[std::countr_zero(active)].normal;
  const std::uint32_t others = active & (active - 1);
  if (plan.stay || active == 0) return;
  const bool leads =
      (others & (others - 1)) == 0 && followFaces(step, deepest(exact, active, step.goal), at, 0, Vec3::Zero(), plan);
  if (leads && (others == 0 || plan.faces != 0)) return;  // Of two that hold it one face alone is not the end.
  plan.lands = true;
  plan.keeps = active;
  for (int i = 0; i < step.count; ++i) {
    const Constraint& c = step.held[i];
    const SceneObject& object = step.scene->slot(c.slot);
    if (active >> i & 1u)
      plan.lands = plan.lands && c.kind == FeatureKind::kFace && isOnFeature(object, c, object.toLocal(foot));
  }
  if (plan.lands || !may_bend || step.count + step.sought_count < 2 || tried) return;
  Plan bent;
  if (planInGroove(step, at, 0, rest, bent)) plan = bent;
}

}  // namespace hapticd
