#include "rt/render/surface/smooth_normal.h"

#include <algorithm>

#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr int kMaxNewton = 8;          // Of Newton's: each doubles the digits.
constexpr double kFound = 1e-12;       // Of the triangle's size: rounding.
constexpr double kLeastShrunk = 0.25;  // Of an edge, where the normals of its ends come together.

/** A triangle and the normals of its corners: it sweeps a prism whose layers are at one height each. */
struct Prism {
  Vec3 v[3], normal[3];
  Vec3 face;         ///< Unit, to the same side.
  double weight[3];  ///< Of the place found.

  bool seek(const Vec3& x) HD_RT;
  [[nodiscard]] Vec3 toLayer(const Vec3& x) const HD_RT;
  [[nodiscard]] Vec3 interpolated() const HD_RT {
    return weight[0] * normal[0] + weight[1] * normal[1] + weight[2] * normal[2];
  }
};

/** x, or the point above the same foot in the outermost layer in which the edges are still long. */
Vec3 Prism::toLayer(const Vec3& x) const HD_RT {
  const double height = face.dot(x - v[0]);
  double shrink = 0;  // Of the edge that shrinks most.
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3;
    const Vec3 along = v[k] - v[i];
    shrink = std::max(shrink, -height * (normal[k] - normal[i]).dot(along) / along.squaredNorm());
  }
  const double most = 1 - kLeastShrunk;
  return shrink <= most ? x : Vec3(x - (1 - most / shrink) * height * face);
}

/** Finds the layer x is in, and its weights there, by Newton's method. False: there is none. */
bool Prism::seek(const Vec3& at) HD_RT {
  const Vec3 x = toLayer(at);
  const Vec3 one = v[1] - v[0], other = v[2] - v[0], turn_one = normal[1] - normal[0],
             turn_other = normal[2] - normal[0];
  const double size2 = one.squaredNorm() + other.squaredNorm();
  const Vec3 area = one.cross(other);
  const double area2 = area.squaredNorm();
  if (!(area2 > 0)) return false;
  double height = face.dot(x - v[0]);
  double a = area.dot((x - v[0]).cross(other)) / area2, b = area.dot(one.cross(x - v[0])) / area2;
  for (int i = 0; i < kMaxNewton; ++i) {
    const Vec3 up = normal[0] + a * turn_one + b * turn_other;
    const Vec3 miss = x - (v[0] + a * one + b * other) - height * up;
    if (miss.squaredNorm() <= kFound * kFound * size2) break;
    const Vec3 along = one + height * turn_one, across = other + height * turn_other, out = along.cross(across);
    const double volume = out.dot(up);
    if (!(std::abs(volume) > 0)) return false;
    a += miss.dot(across.cross(up)) / volume;
    b += miss.dot(up.cross(along)) / volume;
    height += miss.dot(out) / volume;
  }
  weight[0] = 1 - a - b;
  weight[1] = a;
  weight[2] = b;
  return std::isfinite(a) && std::isfinite(b);
}

}  // namespace

bool SmoothSheet::isSmooth(std::uint32_t triangle, std::uint32_t edge) const HD_RT {
  const std::uint32_t across = mesh.neighbours[triangle][edge];
  return across != HD_NO_INDEX && faceNormal(mesh, across).dot(faceNormal(mesh, triangle)) >= crease_cosine;
}

SmoothSheet::Corner SmoothSheet::cornerAt(std::uint32_t triangle, std::uint32_t corner, const Vec3& normal,
                                          std::uint32_t& work) const HD_RT {
  const std::uint32_t vertex = mesh.triangles[triangle][corner];
  Corner all;
  std::uint32_t beside[2] = {triangle, triangle};
  double most[2] = {-2, -2};
  int left = kMaxFan;
  for (const std::uint32_t way : {0u, 1u}) {  // Over the edge that leaves the vertex, and from a border back.
    for (std::uint32_t t = triangle; left > 0; --left, ++work) {
      const int part = all.creases % 2;
      const double cosine = side * faceNormal(mesh, t).dot(normal);
      if (cosine > most[part]) {
        most[part] = cosine;
        all.facet[part] = t;
      }
      beside[way] = t;
      const std::uint32_t edge = (cornerOf(mesh, t, vertex) + 2 * way) % 3, next = mesh.neighbours[t][edge];
      if (next != HD_NO_INDEX && !isSmooth(t, edge)) ++all.creases;
      if (next == triangle) return all;
      t = next;
      if (next != HD_NO_INDEX) continue;
      all.border = true;
      break;
    }
  }
  if (all.border) std::copy_n(beside, 2, all.facet);
  return all;
}

Vec3 SmoothSheet::normalToward(const Vec3& x, std::uint32_t triangle, std::uint32_t& work) const HD_RT {
  std::uint32_t before = HD_NO_INDEX;
  const std::uint32_t most = work + kMaxWork;
  Prism prism, last;
  for (int faces = 1;; ++faces) {
    prism.face = side * faceNormal(mesh, triangle);
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.triangles[triangle][corner];
      const std::uint32_t known = before != HD_NO_INDEX ? cornerOf(mesh, before, vertex) : 0;
      prism.v[corner] = mesh.vertex(triangle, static_cast<int>(corner));
      if (before != HD_NO_INDEX && mesh.triangles[before][known] == vertex) {
        prism.normal[corner] = last.normal[known];
      } else {
        prism.normal[corner] = side * pseudoNormal(mesh, triangle, FeatureKind::kVertex, corner, work, crease_cosine);
      }
    }
    if (!prism.seek(x)) return Vec3::Zero();
    // Over the edge beyond which it lies farthest, of those that lead on.
    std::uint32_t next = HD_NO_INDEX;
    double least = 0;
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t edge = (corner + 1) % 3;
      if (!(prism.weight[corner] < least) || mesh.neighbours[triangle][edge] == before || !isSmooth(triangle, edge))
        continue;
      next = mesh.neighbours[triangle][edge];
      least = prism.weight[corner];
    }
    if (next == HD_NO_INDEX || faces == kMaxFaces || work >= most) break;
    before = triangle;
    last = prism;
    triangle = next;
  }
  double sum = 0;
  for (double& w : prism.weight) sum += w = std::max(0.0, w);
  for (double& w : prism.weight) w /= sum;
  const Vec3 normal = prism.interpolated();
  const double length = normal.norm();
  return length > 0 ? Vec3(normal / length) : Vec3::Zero();
}

}  // namespace hapticd
