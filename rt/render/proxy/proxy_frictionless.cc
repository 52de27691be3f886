// How deep the hand would be without friction: only what is nearer than that is friction's to go around to.
#include <algorithm>
#include <limits>

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/render/proxy/flat_side.h"
#include "rt/render/proxy/proxy_step.h"
#include "rt/render/proxy/seen_face.h"

namespace hapticd {
namespace {

constexpr int kMaxFacesAtRest = 256;  // Looked at for where a proxy without friction would be.

/** Height of x above the faces of a box or cylinder that meet in the rim about `point`, and over it above the rim. */
double heightAtRim(const Shape& shape, FeatureKind kind, const Vec3& point, const Vec3& x) HD_RT {
  Vec3 height = Vec3::Constant(-std::numeric_limits<double>::infinity());
  if (shape.kind == ShapeKind::kCylinder) {
    height[0] = std::copysign(1.0, point.z()) * x.z() - shape.size.y();
    height[1] = x.head<2>().norm() - shape.size.x();
  } else {
    int along = 3;  // Of an edge: where the point is not at the border.
    if (kind == FeatureKind::kEdge) (shape.size - point.cwiseAbs()).maxCoeff(&along);
    for (int i = 0; i < 3; ++i) {
      if (i != along) height[i] = std::copysign(1.0, point[i]) * x[i] - shape.size[i];
    }
  }
  const double out = height.cwiseMax(0.0).norm();
  return out > 0 ? out : height.maxCoeff();
}

/** Of the triangles about a corner the one below whose plane x is least deep. */
std::uint32_t highestAbout(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& x,
                           std::uint32_t& work) HD_RT {
  const std::uint32_t vertex = mesh.triangles[triangle][corner];
  const Vec3 out = x - mesh.vertex(triangle, static_cast<int>(corner));
  std::uint32_t best = triangle, t = triangle;
  double highest = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxFan && t != HD_NO_INDEX && !(i > 0 && t == triangle); ++i, ++work) {
    const double height = faceNormal(mesh, t).dot(out);
    if (height > highest) best = t;
    highest = std::max(highest, height);
    t = mesh.neighbours[t][cornerOf(mesh, t, vertex)];
  }
  return best;
}

}  // namespace

/**
 * Depth of the hip below where a proxy without friction would come to from held[i], along the same surface: the
 * curved one, those that meet in its rim, or faces that lead on from each other. 0 where that is not known: in a
 * hollow, over a border, too far.
 */
double ProxyRenderer::depthAtRest(Step& step, int i) const HD_RT {
  const Constraint& c = step.held[i];
  const SceneObject& object = step.scene->slot(c.slot);
  const Vec3& hip = step.hipIn(c.slot);
  Vec3 normal;
  if (object.shape.kind != ShapeKind::kMesh) {
    if (c.kind != FeatureKind::kFace) return radius_ - heightAtRim(object.shape, c.kind, c.point, hip);
    Constraint there = c;
    double offset = 0;
    return tangentIn(object, there, hip, normal, offset) ? offset - normal.dot(hip) : 0;
  }
  const MeshView& mesh = *object.shape.mesh;
  std::uint32_t triangle = HD_NO_INDEX, before = HD_NO_INDEX;
  if (mesh.neighbours == nullptr) return 0;
  if (c.kind == FeatureKind::kFace) triangle = c.feature;
  if (c.kind == FeatureKind::kEdge) triangle = faceBeyondEdge(mesh, c.feature, c.corner, hip, normal);
  if (c.kind == FeatureKind::kVertex) triangle = highestAbout(mesh, c.feature, c.corner, hip, step.work);
  if (triangle == HD_NO_INDEX) return 0;
  for (int faces = 0; faces < kMaxFacesAtRest; ++faces, ++step.work) {
    SeenFace f(mesh, triangle);
    if (f.isNeedle()) return 0;
    f.seek(hip);
    const double depth = f.up.dot(f.v[0] - hip) / std::sqrt(f.up2);
    const int out = f.out();
    const std::uint32_t next =
        out < 0 ? nearerThanSide(f, hip, depth, kMaxOfSide, step.work) : mesh.neighbours[triangle][out];
    if (out < 0 && (next == HD_NO_INDEX || next == before)) return depth + radius_;
    if (next == HD_NO_INDEX) return 0;
    if (next == before) {  // The feet on both lie beyond the edge they share: in its hollow, or on it if they are flat.
      HalfSpace sides[2];
      Vec3 rest;
      for (int k = 0; k < 2; ++k) {
        const SeenFace side(mesh, k == 0 ? triangle : before);
        sides[k].normal = side.up / std::sqrt(side.up2);
        sides[k].offset = sides[k].normal.dot(side.v[0]) + radius_;
      }
      if (depth < 0 && sides[1].height(hip) + radius_ > 0)  // From the air: the ball lies on the edge itself.
        return radius_ - distanceToEdge(mesh, triangle, static_cast<std::uint32_t>(out), hip);
      return nearestInHollow(sides[0], sides[1], hip, rest) ? (rest - hip).norm() : depth + radius_;
    }
    before = triangle;
    triangle = next;
  }
  return 0;
}

}  // namespace hapticd
