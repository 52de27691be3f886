// From face to face of a mesh: where a proxy that slides on one will come to rest, and the way there.
#include "rt/render/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kMaxTurnCosine = 0.5;  // As far as the normal turns at most at an edge.
constexpr double kFlat = 1e-6;          // Of the squared sine: two faces so much in one plane have no hollow.
constexpr double kTan2 = 1.0 / 3;       // Squared tangent of half the turn at most.
constexpr int kMaxLeads = 3;            // In a tick: what keeps standing in the way is gone along step by step.

/** The point nearest to x on both planes, if both push it there. */
bool nearestInHollow(const HalfSpace& one, const HalfSpace& other, const Vec3& x, Vec3& nearest) HD_RT {
  const double cosine = one.normal.dot(other.normal), sine2 = 1 - cosine * cosine;
  const double to_one = -one.height(x), to_other = -other.height(x);
  const double push = to_one - cosine * to_other, push_other = to_other - cosine * to_one;
  if (!(sine2 > kFlat && push > 0 && push_other > 0)) return false;
  nearest = x + (push / sine2) * one.normal + (push_other / sine2) * other.normal;
  return true;
}

/** Whether x, seen along the plane's normal, is on the inner side of the edges from a to b and from b to c. */
bool covers(const Vec3& a, const Vec3& b, const Vec3& c, const HalfSpace& plane, const Vec3& x) HD_RT {
  return (b - a).cross(x - a).dot(plane.normal) >= 0 && (c - b).cross(x - b).dot(plane.normal) >= 0;
}

/** Of `triangle` the corner that its neighbour does not have. */
Vec3 oppositeCorner(const MeshView& mesh, std::uint32_t triangle, std::uint32_t neighbour) HD_RT {
  const auto& across = mesh.neighbours[triangle];
  return mesh.vertex(triangle, across[0] == neighbour ? 2 : (across[1] == neighbour ? 0 : 1));
}

/**
 * Of a face above the hip's foot, `depth` below it: the neighbour over a ridge whose plane is nearer to the hip.
 * HD_NO_INDEX: there is none.
 */
std::uint32_t nearerNeighbour(const MeshView& mesh, std::uint32_t triangle, const Vec3 (&v)[3], const Vec3& up,
                              const Vec3& hip, double depth) HD_RT {
  if (!(depth > 0)) return HD_NO_INDEX;
  const double deep2 = kTan2 * depth * depth * up.squaredNorm();
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = v[k], &b = v[(k + 1) % 3];
    const Vec3 along = b - a;
    const double in = along.cross(hip - a).dot(up);
    if (in * in > deep2 * along.squaredNorm()) continue;  // Too far from the edge, however it turns.
    const std::uint32_t across = mesh.neighbours[triangle][k];
    if (across == HD_NO_INDEX) continue;
    const Vec3 opposite = oppositeCorner(mesh, across, triangle);
    if (!(up.dot(opposite - a) < 0)) continue;
    const Vec3 there = (opposite - a).cross(along);
    const double height = there.dot(a - hip);
    if (height > 0 && height * height < kClearlyNearer * kClearlyNearer * depth * depth * there.squaredNorm())
      return across;
  }
  return HD_NO_INDEX;
}

/**
 * The edge of a face over which a neighbour rises that a ball touches with its centre at x, above the face: -1 if there
 * is none. The ball touches it before its foot on the face comes to the edge.
 */
int steeperEdge(const MeshView& mesh, std::uint32_t triangle, const Vec3 (&v)[3], const Vec3& up, const Vec3& x,
                double radius) HD_RT {
  const double near2 = kTan2 * radius * radius * up.squaredNorm();
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = v[k], &b = v[(k + 1) % 3];
    const Vec3 along = b - a;
    const double in = along.cross(x - a).dot(up);
    if (in * in > near2 * along.squaredNorm()) continue;
    const std::uint32_t across = mesh.neighbours[triangle][k];
    if (across == HD_NO_INDEX) continue;
    const Vec3 opposite = oppositeCorner(mesh, across, triangle);
    if (!(up.dot(opposite - a) > 0)) continue;
    const Vec3 there = (opposite - a).cross(along);
    if (there.dot(x - a) < radius * there.norm()) return k;
  }
  return -1;
}

}  // namespace

/**
 * The way from `at`, on the first of the faces that follow each other over their edges, to `end` on the last: straight
 * through the air, or, where that would lead below the planes of two, over the edge in which they meet. False, and no
 * way, where neither will do.
 */
bool ProxyRenderer::leadOver(const Step& step, const HalfSpace* face, int count, Vec3 at, const Vec3& end,
                             Plan& plan) HD_RT {
  const double tiny = kNear * step.held[plan.keeps].skin;
  plan.parts = 0;
  for (int i = 0; i + 1 < count; ++i) {
    const HalfSpace &here = face[i], &there = face[i + 1];
    const double cosine = here.normal.dot(there.normal);
    if (cosine < kMaxTurnCosine) return false;
    const double here_at = here.height(at), there_at = there.height(at), here_end = here.height(end),
                 there_end = there.height(end);
    if (there_at >= -tiny && here_end >= -tiny) continue;  // A hollow.
    if (there_at > here_at + tiny || here_end > there_end + tiny) return false;
    const double share = (here_at - there_at) / ((here_at - there_at) + (there_end - here_end));
    const double height = here_at + share * (here_end - here_at);
    if (height >= 0) continue;
    if (!(share >= 0 && share <= 1)) return false;
    at += share * (end - at) - (height / (1 + cosine)) * (here.normal + there.normal);
    plan.way[plan.parts++] = at;
  }
  return true;
}

/**
 * Extends a plan that leads along the face held[i] of a mesh, or out of a groove of which it is a side: if the way ends
 * on this face, it lands there. If it leads over an edge, the neighbours are followed to the face on which the proxy
 * will come to lie, or the groove of two, and the plan leads there. `friction`: the dynamic coefficient of a proxy that
 * slips, 0 of one without friction.
 */
void ProxyRenderer::followFaces(Step& step, int i, const Vec3& at, double friction, Plan& plan) const HD_RT {
  const Constraint& c = step.held[i];
  const SceneObject& object = step.scene->slot(c.slot);
  if (c.kind != FeatureKind::kFace || object.shape.kind != ShapeKind::kMesh ||
      (object.flags & HD_OBJECT_TWO_SIDED) != 0)
    return;
  const MeshView& mesh = *object.shape.mesh;
  if (mesh.neighbours == nullptr) return;
  const Vec3 hip = toLocal(object.X_WO, step.goal);
  const Vec3 x = friction > 0 ? toLocal(object.X_WO, at) : Vec3(Vec3::Zero());
  std::uint32_t triangle = c.feature, before = HD_NO_INDEX;
  Vec3 end;
  HalfSpace face[kMaxFaces];  // Raised by radius and skin.
  int count = 0;
  for (;;) {
    const Vec3 v[3] = {mesh.vertex(triangle, 0), mesh.vertex(triangle, 1), mesh.vertex(triangle, 2)};
    const Vec3 up = (v[1] - v[0]).cross(v[2] - v[0]);
    const double area = up.norm();
    if (!(area > 0)) return;
    HalfSpace& plane = face[count++];
    plane.normal = up / area;
    plane.offset = plane.normal.dot(v[0]) + radius_ + c.skin;
    end = hip;  // Seen along the normal.
    if (friction > 0) {
      const Vec3 away = x - hip, lag = away - plane.normal.dot(away) * plane.normal;
      const double depth = c.skin - plane.height(hip), length = lag.norm();
      if (!(length > friction * depth)) return;
      end += (friction * depth / length) * lag;
    }
    int out = -1;
    double least = 0;
    for (int k = 0; k < 3; ++k) {
      const double in = (v[(k + 1) % 3] - v[k]).cross(end - v[k]).dot(up);
      if (in < least) {
        out = k;
        least = in;
      }
    }
    if (out < 0 && radius_ > 0 && friction == 0)
      out = steeperEdge(mesh, triangle, v, up, end - plane.height(end) * plane.normal, radius_ + c.skin);
    std::uint32_t next = HD_NO_INDEX;
    if (out < 0) {
      if (friction == 0) next = nearerNeighbour(mesh, triangle, v, up, hip, c.skin - plane.height(hip) - radius_);
      if (next == HD_NO_INDEX || next == before || count == kMaxFaces) break;
    } else {
      next = mesh.neighbours[triangle][out];
    }
    if (next == HD_NO_INDEX) return;
    if (next == before) {
      const Vec3 &from = v[out], &to = v[(out + 1) % 3], &third = v[(out + 2) % 3];
      const Vec3 there = oppositeCorner(mesh, before, triangle);
      const bool hollow =
          friction == 0 && plane.normal.dot(there - from) > 0 && nearestInHollow(face[count - 2], plane, hip, end);
      if (!hollow || !covers(to, third, from, plane, end) || !covers(from, there, to, face[count - 2], end)) return;
      plan.faces = 2;
      plan.face[1] = {before, {face[count - 2].normal, face[count - 2].offset - c.skin}};
      break;
    }
    if (count == kMaxFaces) return;
    before = triangle;
    triangle = next;
  }
  plan.keeps = i;
  if (count == 1) {
    plan.lands = true;
    return;
  }
  const HalfSpace& last = face[count - 1];
  plan.face[0] = {triangle, {last.normal, last.offset - c.skin}};
  const bool in_hollow = plan.faces == 2;
  plan.faces = 0;
  if (!(last.height(hip) < -2 * c.skin) || ++step.leads > kMaxLeads) return;
  if (in_hollow) {
    --count;  // The way leads to the face before, which reaches there.
  } else {
    end -= last.height(end) * last.normal;
  }
  const Vec3 end_W = object.X_WO * end;
  for (int k = 0; k < step.count; ++k) {
    const HalfSpace& other = step.held[k].surface;
    if (k != i && other.height(end_W) < step.held[k].skin - kNear * c.skin) return;  // Stands in the way.
  }
  const Vec3 target = plan.target();
  if (!leadOver(step, face, count, toLocal(object.X_WO, at), end, plan)) return plan.goTo(target);
  for (int k = 0; k < plan.parts; ++k) plan.way[k] = object.X_WO * plan.way[k];
  plan.way[plan.parts++] = end_W;
  plan.lands = true;
  plan.slot = c.slot;
  plan.faces = in_hollow ? 2 : 1;
}

/** A face that is known to hold the proxy, a hair below it. */
void ProxyRenderer::holdFace(Step& step, std::uint32_t slot, const MeshPlane& face) HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const HalfSpace& plane = face.plane;
  const Vec3 x = toLocal(object.X_WO, proxy_);
  const double height = plane.height(x);
  hold(step, slot,
       {0, height, plane.normal, plane.offset, face.triangle, FeatureKind::kFace, 0,
        x - (height + radius_) * plane.normal});
}

/** The end of a plan that lands: what holds the proxy there. */
void ProxyRenderer::land(Step& step, const Plan& plan) HD_RT {
  step.settled = step.real = true;
  if (plan.faces == 0) {
    step.held[0] = step.held[plan.keeps];
    step.count = 1;
    return;
  }
  step.count = 0;
  for (int i = 0; i < plan.faces; ++i) holdFace(step, plan.slot, plan.face[i]);
  hint_slot_ = plan.slot;
  hint_ = plan.face[0].triangle;
}

}  // namespace hapticd
