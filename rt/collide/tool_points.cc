#include "rt/collide/tool_points.h"

#include <algorithm>
#include <cmath>

#include "rt/geometry/nearest/pseudo_normal.h"

namespace hapticd {
namespace {

constexpr int kAlongEdge = 9;              ///< Points on a box's edge, its ends included.
constexpr std::uint32_t kBallsAlong = 33;  ///< Along a capsule.
constexpr double kFlatTool = 1e-6;         ///< Of the tool: vertices are floats.

/** Whether every vertex is below every face, but for rounding. */
bool isConvexMesh(const MeshView& mesh, double tolerance) HD_RT {
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    const Vec3 n = faceNormal(mesh, t), on_face = mesh.vertex(t, 0);
    for (std::uint32_t i = 0; i < mesh.vertex_count; ++i) {
      const auto& v = mesh.vertices[i];
      if (n.dot(Vec3(v[0], v[1], v[2]) - on_face) > tolerance) return false;
    }
  }
  return true;
}

}  // namespace

void ToolPoints::add(const Vec3& p) HD_RT {
  if (count_ == kMost) return;
  for (int i = 0; i < 3; ++i) p_[count_][static_cast<std::size_t>(i)] = static_cast<float>(p[i]);
  ++count_;
  reach_ = std::max(reach_, p.norm() + radius_);
  low_ = count_ == 1 ? p : Vec3(low_.cwiseMin(p));
  high_ = count_ == 1 ? p : Vec3(high_.cwiseMax(p));
}

double ToolPoints::alongAxis(std::uint32_t i, double half) HD_RT {
  return half * (2.0 * std::min(i, kBallsAlong - 1) / (kBallsAlong - 1) - 1);
}

void ToolPoints::addBox(const Vec3& half) HD_RT {
  // Corners first: where a budget ends, the most important have been tried.
  for (int corner = 0; corner < 8; ++corner) {
    add({corner & 1 ? half.x() : -half.x(), corner & 2 ? half.y() : -half.y(), corner & 4 ? half.z() : -half.z()});
  }
  for (int i = 0; i < kAlongEdge; ++i) {
    for (int j = 0; j < kAlongEdge; ++j) {
      const double s = 2.0 * i / (kAlongEdge - 1) - 1;
      const double t = 2.0 * j / (kAlongEdge - 1) - 1;
      for (const double side : {-1.0, 1.0}) {
        const bool on_edge_s = i == 0 || i == kAlongEdge - 1;
        const bool on_edge_t = j == 0 || j == kAlongEdge - 1;
        if (on_edge_s && on_edge_t) continue;
        add(half.cwiseProduct(Vec3(s, t, side)));
        if (!on_edge_t) add(half.cwiseProduct(Vec3(s, side, t)));
        if (!on_edge_s && !on_edge_t) add(half.cwiseProduct(Vec3(side, s, t)));
      }
    }
  }
}

void ToolPoints::addCylinder(double radius, double half) HD_RT {
  const auto height = [half](std::uint32_t k) { return half * (2.0 * k / (kRings - 1) - 1); };
  const auto ring = [&](double r, double z, std::uint32_t around) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double a = 2 * EIGEN_PI * i / around;
      add({r * std::cos(a), r * std::sin(a), z});
    }
  };
  ring(radius, -half, kAround);
  ring(radius, half, kAround);
  for (std::uint32_t k = 1; k < kRings - 1; ++k) ring(radius, height(k), kAround);
  for (const double z : {-half, half}) {
    add({0, 0, z});
    ring(radius / 2, z, kAround / 2);
  }
  for (std::uint32_t k = 0; k < kRings; ++k) add({0, 0, height(k)});
}

/** Of a mesh of which not every vertex is a point: no tip of it may be out of what is known to be the tool. */
void ToolPoints::addBounds(const MeshView& mesh) HD_RT {
  if (mesh.node_count == 0) return;
  const hd_bvh_node& root = mesh.nodes[0];
  for (std::uint32_t c = 0; c < root.used; ++c) {
    for (int i = 0; i < 3; ++i) {
      low_[i] = std::min(low_[i], double{root.lower[i][c]});
      high_[i] = std::max(high_[i], double{root.upper[i][c]});
    }
  }
}

void ToolPoints::make(const Shape& shape) HD_RT {
  count_ = 0;
  radius_ = 0;
  reach_ = 0;
  convex_ = shape.kind != ShapeKind::kMesh;
  corners_first_ = shape.kind == ShapeKind::kBox;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      radius_ = shape.size.x();
      add(Vec3::Zero());
      return;
    case ShapeKind::kCapsule:
      radius_ = shape.size.x();
      for (std::uint32_t i = 0; i < kBallsAlong; ++i) add({0, 0, alongAxis(i, shape.size.y())});
      return;
    case ShapeKind::kBox:
      addBox(shape.size);
      return;
    case ShapeKind::kCylinder:
      addCylinder(shape.size.x(), shape.size.y());
      return;
    case ShapeKind::kMesh: {
      if (shape.mesh == nullptr || shape.mesh->deform.vertices != nullptr) return;
      const std::uint32_t vertices = shape.mesh->vertex_count;
      const std::uint32_t n = std::min(vertices, kMost);
      for (std::uint32_t i = 0; i < n; ++i) {
        const auto& v = shape.mesh->vertices[std::uint64_t{i} * vertices / n];
        add({v[0], v[1], v[2]});
      }
      if (n < vertices) addBounds(*shape.mesh);
      convex_ = shape.mesh->triangle_count <= kMostFaces && isConvexMesh(*shape.mesh, kFlatTool * reach_);
      return;
    }
    default:
      return;
  }
}

}  // namespace hapticd
