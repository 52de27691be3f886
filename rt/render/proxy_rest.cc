// The proxy on a face on which it has rested: held without a sweep, which would find the same.
#include "rt/geometry/triangle.h"
#include "rt/render/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kInside = 0x1p-10;  // Of the triangle: so far from its edges no neighbour is as near.

}  // namespace

/** Notes where the proxy rests, if it is on one face of a mesh and on nothing else. */
void ProxyRenderer::noteRest(const Step& step) HD_RT {
  const Constraint& held = step.held[0];
  const SceneObject& object = step.scene->slot(held.slot);
  if (step.count != 1 || held.kind != FeatureKind::kFace || object.shape.kind != ShapeKind::kMesh ||
      (object.flags & HD_OBJECT_TWO_SIDED) != 0) {
    resting_.id = 0;
    return;
  }
  const MeshView& mesh = *object.shape.mesh;
  const bool same_face = resting_.id == object.id && resting_.feature == held.feature &&
                         resting_.number == object.shape.number && resting_.moves == mesh.deform.moves;
  resting_.flags = object.flags;
  if (same_face) return;
  resting_.slot = held.slot;
  resting_.feature = held.feature;
  resting_.number = object.shape.number;
  resting_.moves = mesh.deform.moves;
  const Vec3 v[3] = {mesh.vertex(held.feature, 0), mesh.vertex(held.feature, 1), mesh.vertex(held.feature, 2)};
  const Vec3 up = Corners{v[0], v[1], v[2]}.normal();
  const double length = up.norm();
  resting_.id = length > 0 ? object.id : 0;
  if (length == 0) return;
  resting_.normal = up / length;
  resting_.offset = resting_.normal.dot(v[0]);
  for (int k = 0; k < 3; ++k) {
    const Vec3 inward = resting_.normal.cross(v[(k + 1) % 3] - v[k]);
    resting_.inside[k] = {inward, inward.dot(v[k]) + kInside * length};
  }
}

/**
 * Lets that face hold the proxy if a sweep to the goal would meet it at once: no object has moved, the proxy is a hair
 * above the face and well within its edges, and the goal is below. Counts as the sweep that it replaces.
 */
bool ProxyRenderer::holdAgain(Step& step) HD_RT {
  if (resting_.id == 0 || !step.together || step.sweeps >= kMaxSweeps) return false;
  const SceneObject& object = step.scene->slot(resting_.slot);
  if (object.id != resting_.id || object.flags != resting_.flags || object.shape.number != resting_.number ||
      object.shape.mesh->deform.moves != resting_.moves) {
    return false;
  }
  const double skin = step.skin(object);
  const Vec3& n = resting_.normal;
  const Vec3 x = toLocal(object.X_WO, proxy_);
  const double height = n.dot(x) - resting_.offset - radius_;
  if (!(height > 0.5 * skin && height < 1.5 * skin)) return false;
  if (!(n.dot(toLocal(object.X_WO, step.goal)) - resting_.offset - radius_ < -skin)) return false;
  for (int k = 0; k < 3; ++k) {
    if (resting_.inside[k].height(x) > 0) continue;
    const auto* const neighbours = object.shape.mesh->neighbours;
    if (neighbours != nullptr && neighbours[resting_.feature][k] != HD_NO_INDEX) {
      hint_slot_ = resting_.slot;  // Likely met next.
      hint_ = neighbours[resting_.feature][k];
    }
    return false;
  }
  ++step.sweeps;
  const Vec3 point = x - (height + radius_) * n;
  hold(step, resting_.slot, {0, height, n, resting_.offset + radius_, resting_.feature, FeatureKind::kFace, 0, point});
  return true;
}

}  // namespace hapticd
