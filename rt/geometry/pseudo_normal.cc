#include "rt/geometry/pseudo_normal.h"

#include <algorithm>
#include <cmath>

#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kThin = 0x1p-21;  // Of the coordinates: four times what rounding to floats moves a corner.
constexpr int kMaxThreads = 4;     // One beside the other.

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

/**
 * Whether the triangle is so thin that its corners' rounding decides which way it faces: between floats, where edges of
 * different length were stitched together.
 */
bool isThread(const MeshView& mesh, std::uint32_t triangle) HD_RT {
  const Corners v = cornersOf(mesh, triangle);
  const double longest2 = std::max({(v.b - v.a).squaredNorm(), (v.c - v.b).squaredNorm(), (v.a - v.c).squaredNorm()});
  const double far = std::max({v.a.cwiseAbs().maxCoeff(), v.b.cwiseAbs().maxCoeff(), v.c.cwiseAbs().maxCoeff()});
  const double thin = kThin * far;
  return v.normal().squaredNorm() <= thin * thin * longest2;
}

/** The triangle, or, of a thread entered over edge `entry`, what lies beyond its longer other edge. */
std::uint32_t beyondThreads(const MeshView& mesh, std::uint32_t triangle, std::uint32_t entry) HD_RT {
  for (int i = 0; i < kMaxThreads && triangle != HD_NO_INDEX && isThread(mesh, triangle); ++i) {
    const auto length2 = [&](std::uint32_t k) {
      return (mesh.vertex(triangle, static_cast<int>((k + 1) % 3)) - mesh.vertex(triangle, static_cast<int>(k)))
          .squaredNorm();
    };
    const std::uint32_t one = (entry + 1) % 3, other = (entry + 2) % 3;
    const std::uint32_t exit = length2(one) > length2(other) ? one : other;
    const std::uint32_t next = mesh.neighbours[triangle][exit];
    if (next == HD_NO_INDEX) return next;
    entry = 0;
    while (entry < 2 && mesh.neighbours[next][entry] != triangle) ++entry;
    triangle = next;
  }
  return triangle;
}

/** The triangle's share in the normal of its corner. */
Vec3 weighted(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner) HD_RT {
  const auto at = [&](std::uint32_t c) { return mesh.vertex(triangle, static_cast<int>(c % 3)); };
  const Vec3 v = at(corner);
  return angleBetween(at(corner + 1) - v, at(corner + 2) - v) * faceNormal(mesh, triangle);
}

}  // namespace

Vec3 faceNormal(const MeshView& mesh, std::uint32_t triangle) HD_RT { return unit(cornersOf(mesh, triangle).normal()); }

Vec3 pseudoNormal(const MeshView& mesh, std::uint32_t triangle, FeatureKind kind, std::uint32_t corner,
                  std::uint32_t& work, double crease_cosine) HD_RT {
  ++work;
  if (kind == FeatureKind::kFace || mesh.neighbours == nullptr) return faceNormal(mesh, triangle);
  if (kind == FeatureKind::kEdge) {
    std::uint32_t across = mesh.neighbours[triangle][corner], back = 0;
    if (across != HD_NO_INDEX) {
      while (back < 2 && mesh.neighbours[across][back] != triangle) ++back;
      across = beyondThreads(mesh, across, back);
    }
    const std::uint32_t this_side = beyondThreads(mesh, triangle, corner);
    Vec3 sum = Vec3::Zero();
    if (this_side != HD_NO_INDEX) sum += faceNormal(mesh, this_side);
    if (across != HD_NO_INDEX) sum += faceNormal(mesh, across);
    return unit(sum);
  }
  const std::uint32_t vertex = mesh.triangles[triangle][corner];
  const bool thread = isThread(mesh, triangle);
  const Vec3 first = thread ? Vec3(Vec3::Zero()) : faceNormal(mesh, triangle);
  Vec3 sum = thread ? first : weighted(mesh, triangle, corner);
  for (const std::uint32_t side : {0u, 2u}) {  // Over the edge that leaves the vertex, or back over the one that comes.
    std::uint32_t t = mesh.neighbours[triangle][(corner + side) % 3];
    Vec3 last = first;
    for (int i = 0; i < kMaxFan && t != HD_NO_INDEX; ++i) {
      if (t == triangle) return unit(sum);  // All the way round.
      ++work;
      const std::uint32_t c = cornerOf(mesh, t, vertex);
      if (!isThread(mesh, t)) {
        const Vec3 here = faceNormal(mesh, t);
        if (!last.isZero(0) && here.dot(last) < crease_cosine) break;
        last = here;
        sum += weighted(mesh, t, c);
      }
      t = mesh.neighbours[t][(c + side) % 3];
    }
  }
  return unit(sum);
}

}  // namespace hapticd
