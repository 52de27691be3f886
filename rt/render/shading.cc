#include "rt/render/shading.h"

#include <algorithm>

#include "rt/geometry/nearest.h"
#include "rt/geometry/pseudo_normal.h"

namespace hapticd {
namespace {

constexpr double kOnEdge = 1e-6;      // Barycentric: the proxy is on that edge.
constexpr double kSameNormal = 1e-9;  // 1 - cosine: rounding.

/** Barycentric coordinates of x in a triangle, none below zero. False if it has no area. */
bool weightsIn(const MeshView& mesh, std::uint32_t triangle, const Vec3& x, double (&weight)[3]) HD_RT {
  const Vec3 a = mesh.vertex(triangle, 0), b = mesh.vertex(triangle, 1), c = mesh.vertex(triangle, 2);
  const Vec3 normal = (b - a).cross(c - a);
  const double area = normal.squaredNorm();
  if (!(area > 0)) return false;
  weight[0] = std::max(0.0, normal.dot((c - b).cross(x - b)) / area);
  weight[1] = std::max(0.0, normal.dot((a - c).cross(x - c)) / area);
  weight[2] = std::max(0.0, normal.dot((b - a).cross(x - a)) / area);
  const double sum = weight[0] + weight[1] + weight[2];
  for (double& w : weight) w /= sum;
  return true;
}

/** A support that is not the facet's own normal is that of an edge or corner: all of whose edges have to be smooth. */
bool onSmoothEdge(const MeshView& mesh, std::uint32_t triangle, const Vec3& face, const double (&weight)[3],
                  double cosine) HD_RT {
  bool any = false;
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    if (weight[corner] > kOnEdge) continue;
    const std::uint32_t across = mesh.neighbours[triangle][(corner + 1) % 3];
    if (across == HD_NO_INDEX || faceNormal(mesh, across).dot(face) < cosine) return false;
    any = true;
  }
  return any;
}

/** x turned by the shortest rotation that takes the unit vector `from` to `to` (Rodrigues; they are not opposed). */
Vec3 turned(const Vec3& x, const Vec3& from, const Vec3& to) HD_RT {
  const Vec3 axis = from.cross(to);
  const double cosine = from.dot(to);
  return cosine * x + axis.cross(x) + axis.dot(x) / (1 + cosine) * axis;
}

}  // namespace

void shade(const Scene& scene, const Vec3& v_W, SurfaceContact& contact) HD_RT {
  const SceneObject* object = scene.find(contact.object);
  if (!object || object->shape.kind != ShapeKind::kMesh || !(contact.depth > 0)) return;
  const double cosine = object->surface.parameters.smooth_cosine;
  const MeshView& mesh = *object->shape.mesh;
  if (!(cosine > 0) || !mesh.neighbours) return;

  const Quat q_OW = object->X_WO.q.conjugate();
  NearestQuery query;
  query.x = q_OW * (contact.point - object->X_WO.p);
  query.limit = kMaxShadingWork;
  Nearest nearest;
  const NearestResult found = nearestOnMesh(mesh, query, nearest);
  contact.work += query.work;
  if (found != NearestResult::kFound) return;
  const std::uint32_t triangle = nearest.feature;

  const Vec3 support = q_OW * contact.normal;
  const Vec3 facet = faceNormal(mesh, triangle);
  const double side = facet.dot(support) < 0 ? -1 : 1;  // Two-sided meshes are felt from the back too.
  const Vec3 face = side * facet;
  double weight[3];
  if (!weightsIn(mesh, triangle, nearest.point, weight)) return;
  if (1 - face.dot(support) > kSameNormal && !onSmoothEdge(mesh, triangle, facet, weight, cosine)) return;

  Vec3 smooth = Vec3::Zero();
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    if (weight[corner] == 0) continue;
    smooth += weight[corner] * pseudoNormal(mesh, triangle, FeatureKind::kVertex, corner, contact.work, cosine);
  }
  const double length = smooth.norm();
  if (!(length > 0)) return;
  smooth *= side / length;
  if (smooth.dot(support) < kLeastTurnCosine) return;
  const Vec3 spring = turned(q_OW * contact.force - contact.damping * support, support, smooth);
  const double approach = smooth.dot(q_OW * (object->velocityAt(contact.point) - v_W));
  contact.damping = std::max(object->material.damping * approach, -spring.dot(smooth));
  contact.force = object->X_WO.q * (spring + contact.damping * smooth);
}

}  // namespace hapticd
