// Meshes whose vertices move: they push the proxy out of their way, and take along what stands on them by friction.
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/sweep/moving_triangles.h"
#include "rt/geometry/sweep/sweep.h"
#include "rt/geometry/triangle.h"
#include "rt/render/proxy/proxy_step.h"
#include "rt/scene/vertex_motion.h"

namespace hapticd {
namespace {

constexpr double kLift = 0.5;  // Of a way, over what bulges.

/** Whether nothing of the mesh stands between the points. */
bool sees(const SceneObject& object, const Vec3& from, const Vec3& to, double tolerance, std::uint32_t& work) HD_RT {
  Sweep sweep;
  sweep.a = from;
  sweep.d = to - from;
  sweep.tolerance = tolerance;
  sweep.two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
  sweep.work = work;
  sweep.limit = ProxyRenderer::kMaxWork;
  SweepHit hit;
  const SweepResult result = sweepShape(object.shape, sweep, hit);
  work = sweep.work;
  return result == SweepResult::kNone;
}

/** The same, or over what bulges between them; `up`: unit, from the surface. */
bool leadsTo(const SceneObject& object, const Vec3& from, const Vec3& to, const Vec3& up, double tolerance,
             std::uint32_t& work) HD_RT {
  if (sees(object, from, to, tolerance, work)) return true;
  const Vec3 lift = kLift * (to - from).norm() * up;
  return sees(object, from, from + lift, tolerance, work) && sees(object, from + lift, to + lift, tolerance, work) &&
         sees(object, to + lift, to, tolerance, work);
}

}  // namespace

/**
 * Puts the proxy, in the frame of each mesh that deforms, where the tick's moves of vertices leave it: pushed out of
 * their way, one vertex after the other; and from there, past the mesh as it is then, to the place that it stood on.
 */
void ProxyRenderer::followVertices(Step& step) HD_RT {
  const auto moves = step.scene->triangleMoves();
  if (moves.empty()) return;
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    if (object.shape.kind != ShapeKind::kMesh || object.appeared) continue;
    const MeshView& mesh = *object.shape.mesh;
    if (!step.scene->movesTriangles(mesh)) continue;
    const double skin = step.skin(object);
    const Footing known = footing_.object == object.id && footing_.number == object.shape.number ? footing_ : Footing{};
    const bool two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
    const int on = two_sided ? known.side : 0;
    Vec3 pushed = start_[slot], along = pushed;
    MovingTriangles moving(mesh, moves, pushed, {two_sided, on, skin});
    if (moving.push(pushed, step.work, kMaxWork)) step.carried = true;
    for (const TriangleMove& move : moves) {
      if (known.rubs && move.mesh == &mesh && move.triangle == known.triangle &&
          !isJump(mesh, mesh.triangles[move.triangle][move.corner]))
        along = takenAlong(move, known.weight[move.corner], along);
    }
    const bool taken = along != start_[slot];
    start_[slot] = pushed;
    if (!taken) continue;
    Vec3 up = faceNormal(mesh, known.triangle);
    if (up.dot(along - mesh.vertex(known.triangle, 0)) < 0) up = -up;
    if (!leadsTo(object, pushed, along, up, kNear * skin, step.work)) continue;
    start_[slot] = along;
    step.carried = true;
  }
}

/** Notes on which triangle that may move the proxy lies. */
void ProxyRenderer::noteFooting(const Step& step, std::uint32_t active, const Friction& friction) HD_RT {
  footing_.object = 0;
  if (step.count == 0) return;
  const Constraint& on = step.held[foremost(step, active)];
  const SceneObject& object = step.scene->slot(on.slot);
  if (object.shape.kind != ShapeKind::kMesh || object.shape.mesh->deform.motion == nullptr) return;
  const Vec3 x = startIn(step, on.slot);
  const Corners v = cornersOf(*object.shape.mesh, on.feature);
  const Vec3 foot = nearestOnTriangle(v, x).point, area = v.normal();
  const double nn = area.squaredNorm();
  if (!(nn > 0) || !((x - foot).norm() <= radius_ + kAt * on.skin)) return;
  footing_.weight[1] = area.dot((foot - v.a).cross(v.c - v.a)) / nn;
  footing_.weight[2] = area.dot((v.b - v.a).cross(foot - v.a)) / nn;
  footing_.weight[0] = 1 - footing_.weight[1] - footing_.weight[2];
  footing_.object = object.id;
  footing_.number = object.shape.number;
  footing_.triangle = on.feature;
  footing_.rubs = friction.still > 0;
  const bool faces = on.kind == FeatureKind::kFace;
  footing_.side = !faces ? 0 : on.surface.normal.dot(object.R_WO * area) < 0 ? -1 : 1;
}

}  // namespace hapticd
