// Nearest points of the primitives' surfaces, from outside and inside.
#include <algorithm>
#include <cmath>

#include "rt/geometry/nearest/nearest.h"

namespace hapticd {
namespace {

bool take(const NearestQuery& query, const Vec3& point, const Vec3& normal, std::uint32_t feature,
          Nearest& nearest) HD_RT {
  if (query.turned && !(normal.dot(query.axis) > query.cosine)) return false;
  const double squared = (query.x - point).squaredNorm();
  if (!(squared < nearest.squared_distance)) return false;
  nearest = {point, normal, normal, squared, feature, FeatureKind::kFace, 0};
  return true;
}

/** x / |x|; `otherwise` in the centre. */
Vec3 direction(const Vec3& x, const Vec3& otherwise) HD_RT {
  const double length = x.norm();
  return length > 0 ? Vec3(x / length) : otherwise;
}

/** The surface at `radius` about a point of the axis. */
bool takeRound(const NearestQuery& query, const Vec3& center, const Vec3& otherwise, double radius,
               Nearest& nearest) HD_RT {
  const Vec3 n = direction(query.x - center, otherwise);
  return take(query, center + radius * n, n, 0, nearest);
}

/** Of a solid whose point nearest to x is `inside`: on an edge the way to x is its pseudo-normal. */
bool finish(const NearestQuery& query, const Vec3& inside, bool found, Nearest& nearest) HD_RT {
  if (found) nearest.pseudo_normal = direction(query.x - inside, nearest.normal);
  return found;
}

bool takeBox(const NearestQuery& query, const Vec3& half, Nearest& nearest) HD_RT {
  const Vec3 inside = query.x.cwiseMax(-half).cwiseMin(half);
  bool found = false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      Vec3 on_face = inside;
      on_face[axis] = side * half[axis];
      const auto face = static_cast<std::uint32_t>(2 * axis + (side > 0 ? 0 : 1));
      found |= take(query, on_face, side * Vec3::Unit(axis), face, nearest);
    }
  }
  return finish(query, inside, found, nearest);
}

bool takeCylinder(const NearestQuery& query, double radius, double half, Nearest& nearest) HD_RT {
  const Vec3 radial(query.x.x(), query.x.y(), 0);
  const double distance = radial.norm();
  const double z = std::clamp(query.x.z(), -half, half);
  const Vec3 on_disc = distance > radius ? Vec3(radial * (radius / distance)) : radial;
  bool found = false;
  const Vec3 out = direction(radial, Vec3::UnitX());
  found |= take(query, radius * out + Vec3(0, 0, z), out, 0, nearest);
  found |= take(query, on_disc + Vec3(0, 0, half), Vec3::UnitZ(), 1, nearest);
  found |= take(query, on_disc - Vec3(0, 0, half), -Vec3::UnitZ(), 2, nearest);
  return finish(query, on_disc + Vec3(0, 0, z), found, nearest);
}

bool takeShape(const Shape& shape, const NearestQuery& query, Nearest& nearest) HD_RT {
  switch (shape.kind) {
    case ShapeKind::kPlane:
      return take(query, Vec3(query.x.x(), query.x.y(), 0), Vec3::UnitZ(), 0, nearest);
    case ShapeKind::kSphere:
      return takeRound(query, Vec3::Zero(), Vec3::UnitZ(), shape.size.x(), nearest);
    case ShapeKind::kBox:
      return takeBox(query, shape.size, nearest);
    case ShapeKind::kCapsule: {
      const Vec3 on_axis(0, 0, std::clamp(query.x.z(), -shape.size.y(), shape.size.y()));
      return takeRound(query, on_axis, Vec3::UnitX(), shape.size.x(), nearest);
    }
    case ShapeKind::kCylinder:
      return takeCylinder(query, shape.size.x(), shape.size.y(), nearest);
    case ShapeKind::kGroup:
    case ShapeKind::kMesh:
      break;
  }
  return false;
}

}  // namespace

NearestResult nearestOnShape(const Shape& shape, NearestQuery& query, Nearest& nearest) HD_RT {
  if (shape.kind == ShapeKind::kMesh)
    return shape.mesh ? nearestOnMesh(*shape.mesh, query, nearest) : NearestResult::kNone;
  if (++query.work > query.limit) return NearestResult::kExhausted;
  Nearest best;
  best.squared_distance = query.reach * query.reach;
  if (!takeShape(shape, query, best)) return NearestResult::kNone;
  nearest = best;
  return NearestResult::kFound;
}

}  // namespace hapticd
