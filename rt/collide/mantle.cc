#include "rt/collide/mantle.h"

#include <algorithm>
#include <cmath>

#include "rt/collide/feature.h"

namespace hapticd {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kAlongAxis = 0.1;  ///< Sine of the angle with the axis under which an edge lies along it.
constexpr int kSteps = 5;           ///< Newton's, about a rim.
constexpr double kMostStep = 0.5;   ///< [rad]

bool boxEdge(const Vec3& half, std::uint32_t feature, ObstacleEdge& out) HD_RT {
  const auto side = [&](bool upper, int axis) HD_RT { return upper ? half[axis] : -half[axis]; };
  if (feature >= kFirstBoxEdge) {
    const std::uint32_t edge = feature - kFirstBoxEdge;
    if (edge >= kBoxEdges) return false;
    const int axis = static_cast<int>(edge / 4), u = (axis + 1) % 3, v = (axis + 2) % 3;
    out.from[axis] = -half[axis];
    out.to[axis] = half[axis];
    out.from[u] = out.to[u] = side((edge & 1) != 0, u);
    out.from[v] = out.to[v] = side((edge & 2) != 0, v);
    return true;
  }
  if (feature < kFirstBoxCorner) return false;
  const std::uint32_t corner = feature - kFirstBoxCorner;
  out.from = {side((corner & 1) != 0, 0), side((corner & 2) != 0, 1), side((corner & 4) != 0, 2)};
  out.to = out.from;
  return true;
}

bool rimOf(const Shape& cylinder, std::uint32_t feature, ObstacleEdge& out) HD_RT {
  if (feature < kFirstRim || feature >= kFirstRim + 2 * kRimParts) return false;
  out.from = out.to = {0, 0, feature < kFirstRim + kRimParts ? -cylinder.size.y() : cylinder.size.y()};
  out.radius = cylinder.size.x();
  return true;
}

bool meshEdge(const MeshView& mesh, std::uint32_t feature, ObstacleEdge& out) HD_RT {
  if (feature >= kFirstMeshEdge) {
    const std::uint32_t edge = feature - kFirstMeshEdge, triangle = edge / 3;
    if (triangle >= mesh.triangle_count) return false;
    const int corner = static_cast<int>(edge % 3);
    out.from = mesh.vertex(triangle, corner);
    out.to = mesh.vertex(triangle, (corner + 1) % 3);
    out.goes_on = true;
    return true;
  }
  if (feature < kFirstPeak || feature - kFirstPeak >= mesh.vertex_count) return false;
  const auto& v = mesh.vertices[feature - kFirstPeak];
  out.from = out.to = {v[0], v[1], v[2]};
  return true;
}

/**
 * The place of the rim nearest to the axis, from one near it: where the square of c(s), the way to it from the axis and
 * across that, is least, s the angle about the rim. c = m + u cos s + v sin s, so c'' = m - c.
 */
bool nearestOnRim(const ObstacleEdge& rim, const Pose& X_AE, const Vec3& start, Vec3& out) HD_RT {
  const Vec3 middle = X_AE * rim.from;
  const Vec3 u = X_AE.q * Vec3(rim.radius, 0, 0), v = X_AE.q * Vec3(0, rim.radius, 0);
  const Vec2 m = middle.head<2>();
  double norm = start.head<2>().norm();
  if (!(norm > 0)) return false;
  Vec2 at = start.head<2>() / norm;
  const double least = kAlongAxis * kAlongAxis * rim.radius * rim.radius;
  double bend = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec2 c = m + at.x() * u.head<2>() + at.y() * v.head<2>();
    const Vec2 along = at.x() * v.head<2>() - at.y() * u.head<2>();
    bend = along.squaredNorm() + c.dot(m - c);
    const double step = -c.dot(along) / std::max(std::abs(bend), least);  // Downward wherever it starts.
    const double s = std::clamp(step, -kMostStep, kMostStep);
    at = Vec2(at.x() - s * at.y(), at.y() + s * at.x()).normalized();
  }
  out = middle + at.x() * u + at.y() * v;
  return bend > least;
}

}  // namespace

bool edgeOfFeature(const Shape& obstacle, std::uint32_t feature, ObstacleEdge& out) HD_RT {
  out = {};
  switch (obstacle.kind) {
    case ShapeKind::kBox:
      return boxEdge(obstacle.size, feature, out);
    case ShapeKind::kCylinder:
      return rimOf(obstacle, feature, out);
    case ShapeKind::kMesh:
      return obstacle.mesh != nullptr && meshEdge(*obstacle.mesh, feature, out);
    default:
      return false;
  }
}

MantleMeeting meetMantle(const Shape& a, const ObstacleEdge& edge, const Pose& X_AE, const Vec3& start,
                         MantleTouch& out) HD_RT {
  out.t = 0;
  if (edge.isRim()) {
    if (!nearestOnRim(edge, X_AE, start, out.x)) return MantleMeeting::kNone;
  } else {
    const Vec3 from = X_AE * edge.from, way = X_AE.q * (edge.to - edge.from);
    const double across = way.head<2>().squaredNorm();
    if (across < kAlongAxis * kAlongAxis * way.squaredNorm()) return MantleMeeting::kAlong;
    if (across > 0) out.t = -from.head<2>().dot(way.head<2>()) / across;
    if (!edge.goes_on) out.t = std::clamp(out.t, 0.0, 1.0);
    out.x = from + out.t * way;
  }
  const double radius = out.x.head<2>().norm(), end = a.size.y() - std::abs(out.x.z());
  out.gap = radius - a.size.x();
  if (!(end >= 0)) return MantleMeeting::kBeyond;
  if (!(radius > 0)) return MantleMeeting::kNone;
  if (a.kind == ShapeKind::kCylinder && -out.gap > end) return MantleMeeting::kNone;
  out.n = {-out.x.x() / radius, -out.x.y() / radius, 0};
  return MantleMeeting::kMet;
}

}  // namespace hapticd
