// From face to face of a mesh: where a proxy that slides on one will come to rest, and the way there.
#include <limits>

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"
#include "rt/render/proxy/flat_side.h"
#include "rt/render/proxy/proxy_step.h"
#include "rt/render/proxy/seen_face.h"

namespace hapticd {
namespace {

constexpr double kAbove = 2;    // Times as high as need be: what stands beside the way is cleared, too.
constexpr double kMaxLift = 2;  // Of the straight way: more is rounding, where edges nearly coincide.
constexpr int kFewOfSide = 8;   // Triangles of a flat side whose ridges are looked at.
constexpr int kMaxLeads = 2;    // In a tick: what keeps standing in the way is gone along step by step.

/** Whether x, seen along the normal, is on the inner side of the edges from a to b and from b to c. */
bool covers(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal, const Vec3& x) HD_RT {
  return (b - a).cross(x - a).dot(normal) >= 0 && (c - b).cross(x - b).dot(normal) >= 0;
}

/** Of a face on the way, raised by radius and skin. Not set before it is used: most ways are short. */
struct WalkedPlane {
  Vec3 normal;
  double offset;

  [[nodiscard]] double height(const Vec3& x) const HD_RT { return normal.dot(x) - offset; }
  [[nodiscard]] HalfSpace halfSpace() const HD_RT { return {normal, offset}; }
};

/** Of a walk. A fast hand goes over some twenty a tick of a fine mesh; where a walk is broken off friction leads the
 * next one a little aside. */
constexpr int kMaxFaces = 32;

/** From face to face toward the hip, in the mesh's frame. */
struct Walk {
  const MeshView& mesh;
  Vec3 hip;
  double radius;  ///< Of the ball,
  double skin;    ///< and how far it stays above.
  std::uint32_t& work;
  double friction;  ///< The dynamic coefficient of a proxy that slips, 0 of one without friction.
  WalkedPlane (&face)[kMaxFaces];
  Vec3 eased = Vec3::Zero();  ///< As followFaces() has it.
  Vec3 proxy = Vec3::Zero();  ///< For friction only.

  int count = 0;
  std::uint32_t triangle = HD_NO_INDEX, before = HD_NO_INDEX;  ///< The last two of them.
  Vec3 end = Vec3::Zero();  ///< Where the proxy will come to lie: on both if in a hollow, else above the last one.
  bool in_hollow = false;
  bool hollow_ends = false;  ///< Before where both of the last two faces would be touched.

  bool toEnd(std::uint32_t first) HD_RT;

 private:
  bool seekOn(const WalkedPlane& plane) HD_RT;
  [[nodiscard]] bool seekInHollow(const SeenFace& f, int k) HD_RT;
};

/** Where on the face's plane the proxy would come to rest: seen along its normal. False: it is held where it is. */
bool Walk::seekOn(const WalkedPlane& plane) HD_RT {
  end = hip;
  if (friction == 0) return true;
  const Vec3 away = proxy - hip, lag = away - plane.normal.dot(away) * plane.normal;
  const double depth = -skin - plane.height(hip), length = lag.norm();
  const double cone = friction * std::max(0.0, depth - std::max(0.0, plane.normal.dot(eased)));
  if (!(length > cone)) return false;
  end += cone / length * lag;
  return true;
}

/** Over edge k back to the face before: the end lies in the hollow of the two, if there is one. */
bool Walk::seekInHollow(const SeenFace& f, int k) HD_RT {
  const Vec3 &from = f.v[k], &to = f.v[(k + 1) % 3], &third = f.v[(k + 2) % 3];
  const HalfSpace here = face[count - 1].halfSpace(), there = face[count - 2].halfSpace();
  const Vec3 beyond = oppositeCorner(mesh, before, triangle);
  if (!(friction == 0 && here.normal.dot(beyond - from) > 0 && nearestInHollow(there, here, hip, end))) return false;
  in_hollow = covers(to, third, from, here.normal, end) && covers(from, beyond, to, there.normal, end);
  hollow_ends = !in_hollow;
  return in_hollow;
}

/** False: it leads nowhere, or too far. */
bool Walk::toEnd(std::uint32_t first) HD_RT {
  for (triangle = first;;) {
    SeenFace f(mesh, triangle);
    if (f.isNeedle()) return false;
    WalkedPlane& plane = face[count++];
    plane.normal = f.up / std::sqrt(f.up2);
    plane.offset = plane.normal.dot(f.v[0]) + radius + skin;
    if (!seekOn(plane)) return false;
    f.seek(end);
    int out = f.out();
    if (out < 0 && radius > 0 && friction == 0)
      out = steeperEdge(f, end - plane.height(end) * plane.normal, radius + skin);
    std::uint32_t next = HD_NO_INDEX;
    if (out >= 0) {
      next = mesh.neighbours[triangle][out];
      if (next == HD_NO_INDEX) return false;
      if (next == before) return seekInHollow(f, out);
      if (count == kMaxFaces) return false;
    } else {
      if (friction == 0) next = nearerThanSide(f, hip, -skin - plane.height(hip) - radius, kFewOfSide, work);
      if (next == HD_NO_INDEX || next == before || count == kMaxFaces) return true;
    }
    before = triangle;
    triangle = next;
  }
}

enum class Lead : std::uint8_t { kNone, kStraight, kOver };

/**
 * The way from `at`, on the first of the faces that follow each other over their edges, to `end` on the last: straight
 * through the air, or over one point above all edges on the way. Seen from the side, along the straight way, each plane
 * is a line and each edge the point where two of them meet: the way's first half rises no less steeply than to any of
 * these points, its second half falls no less steeply. (What else stands there stops the sweep.) None where the faces
 * turn too far.
 */
Lead leadOver(const WalkedPlane* face, int count, double tiny, const Vec3& at, const Vec3& end, Vec3& over) HD_RT {
  const Vec3 up = face[0].normal + face[count - 1].normal;
  double rise = 0, fall = 0, before_at = 0, before_end = 0;
  for (int i = 0; i < count; ++i) {
    const double steep = face[i].normal.dot(up);
    if (steep < 2 * kMaxTurnCosine) return Lead::kNone;
    const double below_at = -face[i].height(at) / steep, below_end = -face[i].height(end) / steep;
    if (i == 0) {
      rise = below_end;
    } else {
      const double nearer = below_at - before_at, share = nearer / (nearer - (below_end - before_end));
      if (share > 0 && share < 1) {
        const double high = below_at + share * (below_end - below_at);
        rise = std::max(rise, high / share);
        fall = std::max(fall, high / (1 - share));
      }
    }
    if (i == count - 1) fall = std::max(fall, below_at);
    before_at = below_at;
    before_end = below_end;
  }
  if (!(rise > tiny || fall > tiny)) return Lead::kStraight;
  if (!(rise > tiny)) rise = fall;
  if (!(fall > tiny)) fall = rise;
  const double lift = kAbove * rise * fall / (rise + fall);
  if (!(lift * lift * up.squaredNorm() <= kMaxLift * kMaxLift * (end - at).squaredNorm())) return Lead::kNone;
  over = at + fall / (rise + fall) * (end - at) + lift * up;
  return Lead::kOver;
}

}  // namespace

/**
 * Extends a plan that leads along the face held[i] of a mesh, or out of a groove of which it is a side: if the way ends
 * on this face, it lands there. If it leads over an edge, the neighbours are followed to the face on which the proxy
 * will come to lie, or the hollow of two, and the plan leads there. From an edge on which a ball lies it leads in the
 * same way over the face beyond. `friction` as of a Walk; `eased`: along a face's normal damping takes that much of the
 * depth that its cone counts. False: nothing has been changed.
 */
bool ProxyRenderer::followFaces(Step& step, int i, const Vec3& at_W, double friction, const Vec3& eased,
                                Plan& plan) const HD_RT {
  const Constraint& c = step.held[i];
  const SceneObject& object = step.scene->slot(c.slot);
  if (object.shape.kind != ShapeKind::kMesh || (object.flags & HD_OBJECT_TWO_SIDED) != 0 ||
      object.shape.mesh->neighbours == nullptr || step.walked >= kMaxWalked)
    return false;
  WalkedPlane faces[kMaxFaces];
  Walk walk{*object.shape.mesh, step.hipIn(c.slot), radius_, c.skin, step.work, friction, faces};
  if (friction > 0) {
    walk.proxy = object.toLocal(at_W);
    walk.eased = object.R_WO.transpose() * eased;
  }
  std::uint32_t first = c.feature;
  if (c.kind != FeatureKind::kFace) {
    Vec3 beyond;
    if (c.kind == FeatureKind::kEdge) first = faceBeyondEdge(walk.mesh, c.feature, c.corner, walk.hip, beyond);
    if (c.kind != FeatureKind::kEdge || first == HD_NO_INDEX) return false;
    WalkedPlane& here = walk.face[walk.count++];
    here.normal = object.R_WO.transpose() * c.surface.normal;
    here.offset = c.surface.offset - c.surface.normal.dot(object.X_WO.p) + c.skin;
  }
  const auto lowest = [&](int back) {  // The last of the faces, or the one before.
    const WalkedPlane& plane = walk.face[walk.count - 1 - back];
    return MeshPlane{back == 0 ? walk.triangle : walk.before, {plane.normal, plane.offset - c.skin}};
  };
  const bool ends = walk.toEnd(first);
  const auto looked_at = static_cast<std::uint32_t>(walk.count);
  step.walked += looked_at;
  step.work += looked_at;
  if (!ends) {
    if (walk.hollow_ends) step.seek(c.slot, lowest(0), lowest(1));
    return false;
  }
  if (walk.count == 1) {
    plan.keeps = 1u << i;
    plan.lands = true;
    return true;
  }
  const WalkedPlane& last = walk.face[walk.count - 1];
  if (step.plain || !(last.height(walk.hip) < -2 * c.skin) || ++step.leads > kMaxLeads) return false;
  const Vec3 end = walk.in_hollow ? walk.end : Vec3(walk.end - last.height(walk.end) * last.normal);
  const Vec3 at = object.toLocal(at_W);
  if (step.together && leadsAway(at, end, walk.hip)) return false;
  // Into a hollow the way leads over the face before, which reaches there.
  Vec3 over;
  const Lead lead = leadOver(walk.face, walk.in_hollow ? walk.count - 1 : walk.count, kNear * c.skin, at, end, over);
  if (lead == Lead::kNone) return false;
  plan.goTo(object.toWorld(lead == Lead::kOver ? over : end));
  plan.above[0] = c.surface.normal;
  if (lead == Lead::kOver) {
    plan.way[plan.parts++] = object.toWorld(end);
    plan.above[1] = object.R_WO * last.normal;
  }
  plan.lands = true;
  plan.slot = c.slot;
  plan.face[0] = lowest(0);
  plan.face[1] = lowest(1);
  plan.faces = walk.in_hollow ? 2 : 1;
  return true;
}

/** A face that is known to hold the proxy, a skin below it. */
void ProxyRenderer::holdFace(Step& step, std::uint32_t slot, const MeshPlane& face) HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const HalfSpace& plane = face.plane;
  const Vec3 x = object.toLocal(proxy_);
  const double height = plane.height(x);
  hold(step, slot,
       {0, height, plane.normal, plane.offset, face.triangle, FeatureKind::kFace, 0,
        x - (height + radius_) * plane.normal});
}

/** The end of a plan that lands: what holds the proxy there. */
void ProxyRenderer::land(Step& step, const Plan& plan) HD_RT {
  step.settled = step.real = true;
  if (plan.faces == 0) {
    int kept = 0;
    for (int i = 0; i < 2 * kMaxInGroove; ++i) {
      if (!(plan.keeps >> i & 1u)) continue;
      if (kept != i) step.held[kept] = step.held[i];
      ++kept;
    }
    step.count = kept;
    return;
  }
  step.count = 0;
  for (int i = 0; i < plan.faces; ++i) holdFace(step, plan.slot, plan.face[i]);
  hint_slot_ = plan.slot;
  hint_ = plan.face[0].triangle;
}

}  // namespace hapticd
