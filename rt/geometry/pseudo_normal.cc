#include "rt/geometry/pseudo_normal.h"

#include <cmath>

#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

/**
 * The angle between two vectors, from 0 to pi, to 10^-9: only sums, products and roots, so that every machine gets the
 * same bits.
 */
double angleBetween(const Vec3& a, const Vec3& b) HD_RT {
  double x = a.dot(b), y = a.cross(b).norm();
  double turns = 1;
  for (int halving = 0; halving < 4; ++halving) {  // tan(phi / 2) = y / (x + |.|): below pi / 16, phi may be pi
    const double length = std::sqrt(x * x + y * y);
    if (length == 0) return 0;
    if (x < 0 && y == 0) return 3.14159265358979323846;
    x = (x + length) / length;
    y = y / length;
    turns *= 2;
  }
  const double t = y / x, tt = t * t;
  return turns * t * (1 - tt * (1.0 / 3 - tt * (1.0 / 5 - tt * (1.0 / 7 - tt / 9))));
}

Vec3 unit(const Vec3& x) HD_RT {
  const double length = x.norm();
  return length > 0 ? Vec3(x / length) : Vec3::Zero();
}

/** The triangle's share in the normal of its corner. */
Vec3 weighted(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner) HD_RT {
  const auto at = [&](std::uint32_t c) { return mesh.vertex(triangle, static_cast<int>(c % 3)); };
  const Vec3 v = at(corner);
  return angleBetween(at(corner + 1) - v, at(corner + 2) - v) * faceNormal(mesh, triangle);
}

}  // namespace

Vec3 faceNormal(const MeshView& mesh, std::uint32_t triangle) HD_RT {
  const Vec3 a = mesh.vertex(triangle, 0);
  return unit((mesh.vertex(triangle, 1) - a).cross(mesh.vertex(triangle, 2) - a));
}

Vec3 pseudoNormal(const MeshView& mesh, std::uint32_t triangle, FeatureKind kind, std::uint32_t corner,
                  std::uint32_t& work, double crease_cosine) HD_RT {
  ++work;
  if (kind == FeatureKind::kFace || mesh.neighbours == nullptr) return faceNormal(mesh, triangle);
  if (kind == FeatureKind::kEdge) {
    const std::uint32_t across = mesh.neighbours[triangle][corner];
    const Vec3 here = faceNormal(mesh, triangle);
    return across == HD_NO_INDEX ? here : unit(here + faceNormal(mesh, across));
  }
  const std::uint32_t vertex = mesh.triangles[triangle][corner];
  Vec3 sum = weighted(mesh, triangle, corner);
  for (const std::uint32_t side : {0u, 2u}) {  // Over the edge that leaves the vertex, or back over the one that comes.
    std::uint32_t t = mesh.neighbours[triangle][(corner + side) % 3];
    Vec3 last = faceNormal(mesh, triangle);
    for (int i = 0; i < kMaxFan && t != HD_NO_INDEX; ++i) {
      if (t == triangle) return unit(sum);  // All the way round.
      ++work;
      const Vec3 here = faceNormal(mesh, t);
      if (here.dot(last) < crease_cosine) break;
      last = here;
      const std::uint32_t c = cornerOf(mesh, t, vertex);
      sum += weighted(mesh, t, c);
      t = mesh.neighbours[t][(c + side) % 3];
    }
  }
  return unit(sum);
}

}  // namespace hapticd
