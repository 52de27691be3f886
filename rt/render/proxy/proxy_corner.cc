// In a corner of a mesh: where the planes that hold the proxy do so together, but the surface does not.
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kShort = 1 - 0x1p-8;  // Of an edge: its end is a vertex with faces of its own.
constexpr double kOver = 1.0 / 16;     // Of the way along the edge.
constexpr double kSharpest = 0.02;     // Cosine of half an edge's angle below which it is a blade.

/** Of the edges that leave a vertex the one along which a point comes nearest to the goal. */
struct EdgeToward {
  const MeshView& mesh;
  Vec3 vertex;
  Vec3 goal;  ///< From the vertex.
  double most = 0;
  double length = 0;  ///< How far to go along it.
  Vec3 along = Vec3::Zero();
  Vec3 normal[2];  ///< Of its two faces.

  /** An edge of the triangle, which leads between the vertex and its corner `end`. */
  void look(std::uint32_t triangle, std::uint32_t edge, std::uint32_t end) HD_RT {
    const std::uint32_t across = mesh.neighbours[triangle][edge];
    if (across == HD_NO_INDEX) return;
    const Vec3 to = mesh.vertex(triangle, static_cast<int>(end)) - vertex;
    const double far = to.norm(), toward = far > 0 ? to.dot(goal) / far : 0.0;
    if (!(toward > most)) return;
    most = toward;
    length = std::min(toward, kShort * far);
    along = to / far;
    normal[0] = faceNormal(mesh, triangle);
    normal[1] = faceNormal(mesh, across);
  }
};

/** Whether a triangle of a mesh, or what else the object is, is within `reach` of x, in its frame. */
bool touchesSurface(const SceneObject& object, std::uint32_t feature, const Vec3& x, double reach,
                    std::uint32_t& work) HD_RT {
  if (object.shape.kind == ShapeKind::kMesh)
    return (nearestOnTriangle(cornersOf(*object.shape.mesh, feature), x).point - x).squaredNorm() <= reach * reach;
  Nearest near;
  return nearestWithin(object, x, reach, nullptr, work, near) != NearestResult::kNone;
}

}  // namespace

/**
 * Of planes that were met one after the other some may by now be only planes drawn out, beyond the triangles or solids
 * that were met: these go, but for the last, which has just been. True if there were any, for a proxy that is clearly
 * nearer than at `last`, the distance at which the step let some go before.
 */
bool ProxyRenderer::letGoOfAbsent(Step& step, double& last) const HD_RT {
  const double distance = (proxy_ - step.goal).norm();
  if (step.count < 2 || !step.together || !(distance < kClearlyNearer * last)) return false;
  int kept = 0;
  for (int i = 0; i < step.count; ++i) {
    const Constraint& c = step.held[i];
    const SceneObject& object = step.scene->slot(c.slot);
    if (i + 1 < step.count) {
      const Vec3 x = object.toLocal(proxy_);
      if (!touchesSurface(object, c.feature, x, radius_ + kAt * c.skin, step.work)) continue;
    }
    if (kept != i) step.held[kept] = c;
    ++kept;
  }
  if (kept == step.count) return false;
  step.count = kept;
  last = distance;
  return true;
}

/**
 * Of three faces of a vertex that hold the proxy two may meet in a ridge, and then it is free to go where only one of
 * them is below it: their planes together hold it where the surface does not. The surface about a vertex is made of
 * sectors between its edges, so if any way on it leads nearer to the hip, one along an edge does. A proxy without
 * friction, and without a radius, takes the best of them. False: it stays.
 */
bool ProxyRenderer::leaveVertex(Step& step) HD_RT {
  if (radius_ > 0 || !step.together || step.count < 2) return false;
  const Constraint& c = step.held[step.count - 1];
  const SceneObject& object = step.scene->slot(c.slot);
  if (object.shape.kind != ShapeKind::kMesh || object.shape.mesh->neighbours == nullptr ||
      (object.flags & HD_OBJECT_TWO_SIDED) != 0)
    return false;
  for (int i = 0; i < step.count; ++i)
    if (step.scene->slot(step.held[i].slot).material.friction_static > 0) return false;
  const MeshView& mesh = *object.shape.mesh;
  const Vec3 x = object.toLocal(proxy_);
  std::uint32_t corner = 0;
  while (corner < 3 && !((mesh.vertex(c.feature, static_cast<int>(corner)) - x).norm() <= kAt * c.skin)) ++corner;
  if (corner == 3) return false;
  const std::uint32_t vertex = mesh.triangles[c.feature][corner];
  const Vec3 v = mesh.vertex(c.feature, static_cast<int>(corner));
  EdgeToward edge{mesh, v, object.toLocal(step.goal) - v};
  std::uint32_t t = c.feature;
  for (int i = 0; i < kMaxFan && t != HD_NO_INDEX; ++i) {  // Round the vertex; at a border as far as it goes.
    const std::uint32_t at = cornerOf(mesh, t, vertex);
    edge.look(t, at, (at + 1) % 3);
    edge.look(t, (at + 2) % 3, (at + 2) % 3);
    ++step.work;
    t = mesh.neighbours[t][at];
    if (t == c.feature) break;
  }
  if (!(edge.most > 0)) return false;
  const Vec3 up = (edge.normal[0] + edge.normal[1]).normalized();
  const double steep = up.dot(edge.normal[0]);
  if (!(steep > kSharpest)) return false;
  const Vec3 target = object.toWorld(v + edge.length * edge.along + c.skin / steep * up);
  if (!((target - step.goal).norm() < kClearlyNearer * (proxy_ - step.goal).norm())) return false;
  // Straight, or, where a ridge lies between, over a point above the edge's faces.
  const Vec3 over[] = {proxy_ + kOver * edge.length * (object.R_WO * up), target};
  if (!goVia(step, &target, 1, kAnyLength) && !goVia(step, over, 2, kAnyLength)) return false;
  step.settled = false;
  return true;
}

}  // namespace hapticd
