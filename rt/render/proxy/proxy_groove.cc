// A proxy held by several surfaces at once: where in their groove, or corner, it will come to lie, and the way there.
#include <bit>

#include "rt/geometry/triangle.h"
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr int kMaxTurns = 16;       // Of the tangent planes.
constexpr int kMaxWalks = 8;        // Of these, that may lead to other triangles;
constexpr int kMaxPointWalks = 3;   // of a point, whose planes do not turn.
constexpr int kMaxBelow = 8;        // Triangles, from one that holds the proxy to that below its place.
constexpr double kSteepest = 0.02;  // Cosine: what leans more is gone along step by step.
constexpr double kMaxLeap = 0.125;  // Of the depth: by how much each may be put farther along the groove.

/**
 * The next triangle about a corner toward x, beyond it: over the edge that x is farther beyond, or over the other one
 * if that leads back. HD_NO_INDEX: there is none.
 */
std::uint32_t nextAbout(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& normal,
                        const Vec3& x, std::uint32_t before) HD_RT {
  const Vec3 v = mesh.vertex(triangle, static_cast<int>(corner)), away = x - v;
  const std::uint32_t last = (corner + 2) % 3;
  const Vec3 to = mesh.vertex(triangle, static_cast<int>(corner + 1) % 3) - v;
  const Vec3 from = v - mesh.vertex(triangle, static_cast<int>(last));
  const bool first = away.dot(to.cross(normal)) * from.norm() > away.dot(from.cross(normal)) * to.norm();
  const std::uint32_t over = mesh.neighbours[triangle][first ? corner : last];
  const std::uint32_t other = mesh.neighbours[triangle][first ? last : corner];
  if (over != HD_NO_INDEX && over != before) return over;
  return other != before ? other : HD_NO_INDEX;
}

/** Whether x is above or below the triangle. */
bool isOver(const MeshView& mesh, std::uint32_t triangle, const Vec3& x) HD_RT {
  const Corners v = cornersOf(mesh, triangle);
  const Vec3 n = v.normal();
  return (v.b - v.a).cross(x - v.a).dot(n) > 0 && (v.c - v.b).cross(x - v.b).dot(n) > 0 &&
         (v.a - v.c).cross(x - v.c).dot(n) > 0;
}

/**
 * From `at`, put onto the planes that keep the goal out, to the border of the cone about `foot`, where they let a point
 * be without friction; `foot` is then that place. False: the planes are nearly parallel.
 */
bool slideTo(const HalfSpace* planes, std::uint32_t active, const Vec3& goal, Vec3 at, double friction,
             Vec3& foot) HD_RT {
  if (active == 0 || !nearestOnPlanes(planes, active, at)) return false;
  const Vec3 lag = at - foot;
  const double r = lag.norm(), cone = friction * (foot - goal).norm();
  if (r > 0) foot += cone / r * lag;
  return true;
}

/** Of two planes' normals their shares in `push`, which lies in the plane of both. */
void sharesOf(const Vec3& one, const Vec3& other, const Vec3& push, double (&share)[2]) HD_RT {
  const double cosine = one.dot(other), sine2 = 1 - cosine * cosine;
  const double to_one = one.dot(push), to_other = other.dot(push);
  share[0] = (to_one - cosine * to_other) / sine2;
  share[1] = (to_other - cosine * to_one) / sine2;
}

}  // namespace

bool ProxyRenderer::Step::isHeldByFaces() const HD_RT {
  for (int i = 0; i < count; ++i) {
    const Constraint& c = held[i];
    if (c.kind != FeatureKind::kFace || scene->slot(c.slot).shape.kind != ShapeKind::kMesh) return false;
  }
  return true;
}

/** What holds the proxy, and the faces sought; how many. */
int ProxyRenderer::sidesOf(const Step& step, Constraint (&side)[kMaxInGroove]) HD_RT {
  int count = 0;
  for (; count < step.count; ++count) side[count] = step.held[count];
  for (int k = 0; k < step.sought_count && count < kMaxInGroove; ++k) {
    const MeshPlane& face = step.sought[k];
    bool known = false;
    for (int i = 0; i < count; ++i) {
      const Constraint& c = side[i];
      known = known || (c.slot == step.sought_slot && c.feature == face.triangle && c.kind == FeatureKind::kFace);
    }
    if (known) continue;
    const SceneObject& object = step.scene->slot(step.sought_slot);
    Constraint& c = side[count++];
    c.slot = step.sought_slot;
    c.feature = face.triangle;
    c.kind = FeatureKind::kFace;
    c.corner = 0;
    c.surface.normal = object.R_WO * face.plane.normal;
    c.surface.offset = face.plane.offset + c.surface.normal.dot(object.X_WO.p);
    c.skin = step.skin(object);
  }
  return count;
}

/**
 * Walks on a one-sided mesh from the triangle of `c` to the face or edge below x, in the object's frame, that the ball
 * touches there. False: it leads to no one place.
 */
bool ProxyRenderer::walkBelow(const SceneObject& object, const Constraint& c, const Vec3& x,
                              Constraint& there) const HD_RT {
  const MeshView& mesh = *object.shape.mesh;
  std::uint32_t triangle = c.feature, before = HD_NO_INDEX;
  for (int walked = 0; walked < kMaxBelow; ++walked) {
    const Corners corners = cornersOf(mesh, triangle);
    const Vec3 up = corners.normal();
    if (!(up.squaredNorm() > 0)) return false;  // Without area.
    const TriangleFoot foot = nearestOnTriangle(corners, x);
    std::uint32_t next = HD_NO_INDEX;
    if (foot.kind == FeatureKind::kEdge) next = mesh.neighbours[triangle][foot.corner];
    if (foot.kind == FeatureKind::kVertex) {
      next = nextAbout(mesh, triangle, foot.corner, up, x, before);
      if (next == HD_NO_INDEX) return false;
    } else if (next == before || next == HD_NO_INDEX) {
      Vec3 normal = up / up.norm();
      if (foot.kind == FeatureKind::kEdge) {
        const Vec3 out = x - foot.point;
        if (radius_ == 0 || !(out.dot(normal) > 0)) return false;
        normal = out.normalized();
      }
      there = c;
      there.feature = triangle;
      there.kind = foot.kind;
      there.corner = foot.kind == FeatureKind::kFace ? 0 : foot.corner;
      there.point = foot.point;
      there.surface.normal = object.R_WO * normal;
      there.surface.offset = normal.dot(foot.point) + radius_ + there.surface.normal.dot(object.X_WO.p);
      return true;
    }
    before = triangle;
    triangle = next;
  }
  return false;
}

/**
 * The tangent plane near x of the surface that goes on from `c`, grown by the radius; x is in the object's frame.
 * `there` is where it was looked for last. False: it is that of `c`.
 */
bool ProxyRenderer::sideAt(const SceneObject& object, const Constraint& c, const Vec3& x,
                           Constraint& there) const HD_RT {
  const bool on_mesh = object.shape.kind == ShapeKind::kMesh;
  if (on_mesh && there.kind == FeatureKind::kFace && isOver(*object.shape.mesh, there.feature, x))
    return c.kind != FeatureKind::kFace || there.feature != c.feature;
  const bool walks = on_mesh && c.kind != FeatureKind::kVertex && (object.flags & HD_OBJECT_TWO_SIDED) == 0 &&
                     object.shape.mesh->neighbours != nullptr;
  if (!walks || !walkBelow(object, c, x, there)) return tangentTo(object, c, x, there);
  return there.kind != FeatureKind::kFace || c.kind != FeatureKind::kFace || there.feature != c.feature;
}

/** Curvature, along the unit vector e, of what the ball's centre rolls on about c; negative: not known. */
double ProxyRenderer::curvatureAlong(const SceneObject& object, const Constraint& c, const Vec3& e) const HD_RT {
  if (object.shape.kind != ShapeKind::kMesh || radius_ == 0) return -1;
  if (c.kind == FeatureKind::kFace) return 0;
  if (c.kind == FeatureKind::kVertex) return 1 / radius_;
  const MeshView& mesh = *object.shape.mesh;
  const Vec3 edge =
      mesh.vertex(c.feature, static_cast<int>(c.corner + 1) % 3) - mesh.vertex(c.feature, static_cast<int>(c.corner));
  const double along = (object.R_WO * edge).dot(e);
  return std::max(0.0, 1 - along * along / edge.squaredNorm()) / radius_;
}

/**
 * From x, where the sides in `keeps` are touched by `planes`, and the point `next` of these that is nearest to the
 * goal: which part of `next - x` each turn of the planes leaves to the next one, and `way`, of which it is a part. Let
 * the sides push by l_i along their normals and be curved by k_i along their groove. Then turning the planes to x + d
 * moves the point by (sum l_i k_i) d, and the rest of the way is a geometric series: a step of Newton's. Negative: not
 * known.
 */
double ProxyRenderer::shareLeft(const Step& step, const Constraint* side, const HalfSpace* planes, std::uint32_t keeps,
                                const Vec3& next, Vec3& way) const HD_RT {
  const int count = std::popcount(keeps);
  if (count == 0 || count > 2) return -1;
  const int i[2] = {std::countr_zero(keeps), 31 - std::countl_zero(keeps)};
  const Vec3 push = next - step.goal;
  const Vec3 &one = planes[i[0]].normal, &other = planes[i[1]].normal;
  double share[2] = {one.dot(push), 0};
  if (count == 2) sharesOf(one, other, push, share);
  Vec3 e = count == 2 ? Vec3(one.cross(other)) : Vec3(way - one.dot(way) * one);
  const double length = e.norm();
  if (!(length > 0)) return -1;
  e /= length;
  double left = 0;
  for (int k = 0; k < count; ++k) {
    const Constraint& c = side[i[k]];
    const double curvature = curvatureAlong(step.scene->slot(c.slot), c, e);
    if (curvature < 0) return -1;
    left += share[k] * curvature;
  }
  way = way.dot(e) * e;
  return left;
}

/**
 * In the groove of two surfaces, or the corner of three, that are curved or go on over edges: to the point of all of
 * them nearest to the goal, found by turning their tangent planes before anything is swept; over a point above these
 * and the present ones. With friction it goes no farther than to the border of its cone about that point.
 */
bool ProxyRenderer::planInGroove(Step& step, const Vec3& here, double friction, double rest, Plan& plan) HD_RT {
  Constraint from[kMaxInGroove];
  const int count = sidesOf(step, from);
  Constraint* const there = step.held + step.count;
  HalfSpace planes[kMaxInGroove];
  double tolerance = 0;
  bool in_parts = true;  // But an edge of a mesh, drawn out, is not there far from here.
  for (int i = 0; i < count; ++i) {
    tolerance = std::max(tolerance, kNear * from[i].skin);
    there[i] = from[i];
    in_parts = in_parts &&
               (from[i].kind == FeatureKind::kFace || step.scene->slot(from[i].slot).shape.kind != ShapeKind::kMesh);
  }
  const int most_walks = radius_ > 0 ? kMaxWalks : kMaxPointWalks;
  Vec3 last = here, moved = Vec3::Zero(), found = here;
  std::uint32_t keeps = 0;
  bool turned = step.sought_count > 0 || step.isHeldByFaces();  // Faces do when one is left.
  bool leapt = false, far = false;
  for (int turn = 0;; ++turn, ++step.turns) {
    bool walks = false, same = turn > 0 && !leapt;
    HalfSpace now[kMaxInGroove];
    for (int i = 0; i < count; ++i) {
      const SceneObject& object = step.scene->slot(from[i].slot);
      const std::uint32_t feature = there[i].feature;
      turned = (turn > 0 && sideAt(object, from[i], object.toLocal(last), there[i])) || turned;
      walks = walks || there[i].feature != feature;
      far = far || there[i].surface.normal.dot(from[i].surface.normal) < kMaxTurnCosine;
      now[i] = {there[i].surface.normal, there[i].surface.offset + from[i].skin};
      same = same && now[i].normal == planes[i].normal && now[i].offset == planes[i].offset;
    }
    if (far) {  // As far as they turn in one plan, and again from there.
      if (!in_parts) return false;
      last = found;
      break;
    }
    std::copy(now, now + count, planes);
    if (turn > 0 && !turned) return false;
    if (same) break;
    Vec3 next = step.goal;
    if (!nearestInside(planes, count, tolerance, next, keeps)) return false;
    if (friction > 0 && !slideTo(planes, keeps, step.goal, last, friction, next)) return false;
    const Vec3 move = next - last;
    last = found = next;
    if (move.norm() <= rest) break;
    in_parts = in_parts && !walks;
    if (turn >= kMaxTurns) {  // The same, where each turn leads only a little farther.
      if (!in_parts) return false;
      far = true;
      break;
    }
    if (walks && turn >= most_walks) return false;  // To and fro: more than these sides hold it there.
    // Each turn shortens the rest of the way by about the same factor: all at once.
    Vec3 way = move;
    double factor = turn > 0 && friction == 0 ? shareLeft(step, there, planes, keeps, next, way) : -1.0;
    if (!(factor >= 0 && factor < 1 && move.squaredNorm() < moved.squaredNorm())) {
      way = move;
      factor = turn % 2 == 1 ? move.dot(moved) / moved.squaredNorm() : 0.0;  // As it was in the last one (Aitken).
    }
    const double farthest = kMaxLeap * (last - step.goal).norm() / move.norm();
    leapt = factor > 0;
    if (leapt) last += (factor < 1 ? std::min(factor / (1 - factor), farthest) : farthest) * way;
    moved = move;
  }
  if (friction > 0 && !far && (last - here).norm() <= rest) {
    plan.goTo(here);
    return plan.stay = true;
  }
  if ((last - here).norm() <= rest || (step.together && leadsAway(here, last, step.goal))) return false;
  Vec3 up = Vec3::Zero();
  for (int i = 0; i < count; ++i) up += from[i].surface.normal + planes[i].normal;
  up.normalize();
  double lift = 0;
  for (int i = 0; i < count; ++i) {
    const double steep = std::min(up.dot(from[i].surface.normal), up.dot(planes[i].normal));
    if (!(steep > kSteepest)) return false;
    lift = std::max(lift, (from[i].skin - from[i].surface.height(last)) / steep);
  }
  plan.goTo(last);
  if (lift > tolerance) {
    plan.goTo(last + lift * up);
    plan.way[plan.parts++] = last;
    plan.above[1] = planes[0].normal;
  }
  plan.above[0] = from[0].surface.normal;
  plan.in_groove = true;
  plan.lands = !far && keeps != 0;
  plan.keeps = keeps << step.count;
  for (int i = 0; i < count; ++i) {
    const SceneObject& object = step.scene->slot(there[i].slot);
    if (keeps >> i & 1u) plan.lands = plan.lands && isOnFeature(object, there[i], object.toLocal(last));
  }
  return true;
}

}  // namespace hapticd
