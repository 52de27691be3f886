#include "tools/haptic-bench/model/nearest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

/** Where on a triangle a point is: its inside, edge 0 (ab), 1 (bc), 2 (ca), or corner 0 to 2. */
struct Place {
  enum class Kind { kFace, kEdge, kCorner } kind = Kind::kFace;
  int which = 0;
  Vec3 offset = Vec3::Zero();  ///< From corner a.
};

/** Nearest point of a triangle to p, both relative to corner a: Ericson, Real-Time Collision Detection, 5.1.5. */
Place nearestOnTriangle(const Vec3& ab, const Vec3& ac, const Vec3& p) {
  using Kind = Place::Kind;
  const double d1 = ab.dot(p), d2 = ac.dot(p);
  if (d1 <= 0 && d2 <= 0) return {Kind::kCorner, 0, Vec3::Zero()};
  const Vec3 b = p - ab;
  const double d3 = ab.dot(b), d4 = ac.dot(b);
  if (d3 >= 0 && d4 <= d3) return {Kind::kCorner, 1, ab};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {Kind::kEdge, 0, ab * (d1 / (d1 - d3))};
  const Vec3 c = p - ac;
  const double d5 = ab.dot(c), d6 = ac.dot(c);
  if (d6 >= 0 && d5 <= d6) return {Kind::kCorner, 2, ac};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {Kind::kEdge, 2, ac * (d2 / (d2 - d6))};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return {Kind::kEdge, 1, ab + (ac - ab) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))};
  }
  const double sum = va + vb + vc;
  return {Kind::kFace, 0, ab * (vb / sum) + ac * (vc / sum)};
}

double angleBetween(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

NearestPoint::NearestPoint(const Model& model) : vertex_normals_(model.vertices.size(), Vec3(Vec3::Zero())) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3> edges;
  const auto edge = [&edges](std::uint32_t a, std::uint32_t b) -> Vec3& {
    return edges.try_emplace(std::minmax(a, b), Vec3::Zero()).first->second;
  };
  for (std::uint32_t t = 0; t < model.triangles.size(); ++t) {
    const Vec3 x[3] = {model.corner(t, 0), model.corner(t, 1), model.corner(t, 2)};
    const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    if (!(normal.norm() > 0.5)) continue;
    const std::array<std::uint32_t, 3>& v = model.triangles[t];
    for (std::size_t c = 0; c < 3; ++c) {
      edge(v[c], v[(c + 1) % 3]) += normal;
      vertex_normals_[v[c]] += normal * angleBetween(x[(c + 1) % 3] - x[c], x[(c + 2) % 3] - x[c]);
    }
    const Vec3 center = (x[0] + x[1] + x[2]) / 3;
    const double radius = std::max({(x[0] - center).norm(), (x[1] - center).norm(), (x[2] - center).norm()});
    // A float's rounding of the centre is at most 2^-23 of it.
    balls_.push_back({static_cast<float>(center.x()), static_cast<float>(center.y()), static_cast<float>(center.z()),
                      static_cast<float>(1.000001 * radius + 0x1p-22 * center.norm())});
    faces_.push_back({x[0], x[1] - x[0], x[2] - x[0], normal, v, {}});
  }
  constexpr double kCancelled = 1e-9;  // Of angles: what is left is rounding.
  for (Vec3& n : vertex_normals_) n = n.norm() > kCancelled ? Vec3(n.normalized()) : Vec3(Vec3::Zero());
  for (Face& face : faces_) {
    for (std::size_t c = 0; c < 3; ++c) {
      face.edge_normals[c] = edge(face.vertices[c], face.vertices[(c + 1) % 3]).normalized();
    }
  }
}

SurfacePoint NearestPoint::find(const Vec3& x) const {
  const float px = static_cast<float>(x.x()), py = static_cast<float>(x.y()), pz = static_cast<float>(x.z());
  const auto slack = static_cast<float>(0x1p-21 * x.cwiseAbs().maxCoeff());
  double best = std::numeric_limits<double>::infinity();
  float reach = std::numeric_limits<float>::infinity();
  std::uint32_t nearest = 0;
  Place place;
  for (std::uint32_t t = 0; t < faces_.size(); ++t) {
    const Ball& ball = balls_[t];
    const float dx = px - ball.x, dy = py - ball.y, dz = pz - ball.z, far = reach + ball.radius;
    if (dx * dx + dy * dy + dz * dz > far * far) continue;
    const Place here = nearestOnTriangle(faces_[t].ab, faces_[t].ac, x - faces_[t].a);
    const double d2 = (x - faces_[t].a - here.offset).squaredNorm();
    if (d2 >= best) continue;
    best = d2;
    reach = static_cast<float>(std::sqrt(d2)) * 1.000001f + slack;
    nearest = t;
    place = here;
  }
  SurfacePoint found;
  if (faces_.empty()) return found;
  const Face& face = faces_[nearest];
  found.triangle = nearest;
  found.point = face.a + place.offset;
  found.distance = std::sqrt(best);
  switch (place.kind) {
    case Place::Kind::kFace:
      found.normal = face.normal;
      break;
    case Place::Kind::kEdge:
      found.normal = face.edge_normals[static_cast<std::size_t>(place.which)];
      break;
    case Place::Kind::kCorner:
      found.normal = vertex_normals_[face.vertices[static_cast<std::size_t>(place.which)]];
      break;
  }
  found.inside = (x - found.point).dot(found.normal) < 0;
  return found;
}

std::size_t NearestPoint::bytes() const {
  return balls_.size() * sizeof(Ball) + faces_.size() * sizeof(Face) + vertex_normals_.size() * sizeof(Vec3);
}

Eigen::AlignedBox3d boxOf(const Model& model) {
  Eigen::AlignedBox3d box;
  for (std::uint32_t v = 0; v < model.vertices.size(); ++v) box.extend(model.vertex(v));
  return box;
}

void requireNear(const Model& model, double rms, const std::string& what, const std::string& remedy) {
  constexpr double kNear = 0.1;
  const double large = boxOf(model).diagonal().norm();
  if (rms <= kNear * large) return;
  throw Failure(fmt::format("{} lie {:.3g} mm rms off the surface of a mesh of {:.3g} mm ({})", what, 1000 * rms,
                            1000 * large, remedy));
}

}  // namespace haptic_bench
