#include "rt/geometry/nearest/pseudo_normal.h"

#include <algorithm>
#include <cmath>

#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kThin = 0x1p-23;  // Of the coordinates: what rounding to floats moves a corner, and hardly more.
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

[[gnu::always_inline]] inline Vec3 unit(const Vec3& x) HD_RT {
  const double length = x.norm();
  return length > 0 ? Vec3(x / length) : Vec3::Zero();
}

/** Which edge of the triangle leads to that neighbour. */
std::uint32_t edgeTo(const MeshView& mesh, std::uint32_t triangle, std::uint32_t neighbour) HD_RT {
  const MeshView::Index3& across = mesh.neighbours[triangle];
  return across[0] == neighbour ? 0 : (across[1] == neighbour ? 1 : 2);
}

/** A triangle's corners and normal. */
struct Face {
  Vec3 v[3];
  Vec3 area;  ///< Twice the area long.

  Face(const MeshView& mesh, std::uint32_t triangle) HD_RT
      : v{mesh.vertex(triangle, 0), mesh.vertex(triangle, 1), mesh.vertex(triangle, 2)},
        area(areaVector(v[1] - v[0], v[2] - v[0])) {}
  [[nodiscard]] Vec3 normal() const HD_RT { return unit(area); }
  /**
   * Whether it is so thin that its corners' rounding may fold it over: between floats, where edges of different length
   * were stitched together. What is wider, however tipped, has its own say: the theorem asks no more of it. Its longest
   * edge is taken for one of the first corner's, and its distance for that corner's: neither is twice as far off.
   */
  [[nodiscard]] bool isThread() const HD_RT {
    const double one2 = (v[1] - v[0]).squaredNorm(), other2 = (v[2] - v[0]).squaredNorm();
    return area.squaredNorm() <= kThin * kThin * (v[0].squaredNorm() + one2) * std::max(one2, other2);
  }
  /** Whether the ends of the edge that begins at the corner are taken for one vertex; on both of its sides alike. */
  [[nodiscard]] bool isShut(std::uint32_t corner) const HD_RT {
    return length2(corner) <= kThin * kThin * (v[corner].squaredNorm() + v[(corner + 1) % 3].squaredNorm());
  }
  /** Of the edge that begins at the corner, squared. */
  [[nodiscard]] double length2(std::uint32_t corner) const HD_RT {
    return (v[(corner + 1) % 3] - v[corner]).squaredNorm();
  }
  /** At the corner. */
  [[nodiscard]] double angle(std::uint32_t corner) const HD_RT {
    return angleBetween(v[(corner + 1) % 3] - v[corner], v[(corner + 2) % 3] - v[corner]);
  }
};

/**
 * Of the triangle, seen from its neighbour `from`; if it is a thread, of what lies beyond the longer of its other
 * edges. Zero at a border.
 */
Vec3 sheetNormal(const MeshView& mesh, std::uint32_t triangle, std::uint32_t from) HD_RT {
  for (int i = 0;; ++i) {
    const Face face(mesh, triangle);
    if (i == kMaxThreads || !face.isThread()) return face.normal();
    const std::uint32_t entry = edgeTo(mesh, triangle, from), one = (entry + 1) % 3, other = (entry + 2) % 3;
    const std::uint32_t exit = face.length2(one) > face.length2(other) ? one : other;
    from = triangle;
    triangle = mesh.neighbours[triangle][exit];
    if (triangle == HD_NO_INDEX) return Vec3::Zero();
  }
}

/**
 * What a thread stands for about one of its corners: the normal of the sheet beyond the edge opposite to it, times the
 * angle there. Zero at a border.
 */
Vec3 sheetBeyond(const MeshView& mesh, const Face& thread, std::uint32_t triangle, std::uint32_t corner) HD_RT {
  const std::uint32_t across = mesh.neighbours[triangle][(corner + 1) % 3];
  if (across == HD_NO_INDEX) return Vec3::Zero();
  return thread.angle(corner) * sheetNormal(mesh, across, triangle);
}

/** A triangle about a vertex, or about several that shut edges make one. */
struct Spoke {
  std::uint32_t triangle, vertex, corner;
  Face face;

  Spoke(const MeshView& mesh, std::uint32_t t, std::uint32_t v) HD_RT : triangle(t),
                                                                        vertex(v),
                                                                        corner(cornerOf(mesh, t, v)),
                                                                        face(mesh, t) {}
  /** Of its two edges at the corner the one that leaves (0) or comes (2). */
  [[nodiscard]] bool isShut(std::uint32_t side) const HD_RT { return face.isShut((corner + side) % 3); }
  /** The edge over which to go on, that way round; `next` receives the vertex about which. */
  [[nodiscard]] std::uint32_t exit(const MeshView& mesh, std::uint32_t side, std::uint32_t& next) const HD_RT {
    next = vertex;
    if (!isShut(side)) return (corner + side) % 3;
    next = mesh.triangles[triangle][(corner + (side == 0 ? 1 : 2)) % 3];
    return (corner + 1) % 3;
  }
};

}  // namespace

Vec3 faceNormal(const MeshView& mesh, std::uint32_t triangle) HD_RT { return unit(cornersOf(mesh, triangle).normal()); }

Vec3 pseudoNormal(const MeshView& mesh, std::uint32_t triangle, FeatureKind kind, std::uint32_t corner,
                  std::uint32_t& work, double crease_cosine) HD_RT {
  ++work;
  if (kind == FeatureKind::kFace || mesh.neighbours == nullptr) return faceNormal(mesh, triangle);
  if (kind == FeatureKind::kEdge) {
    const std::uint32_t across = mesh.neighbours[triangle][corner];
    if (across == HD_NO_INDEX) return faceNormal(mesh, triangle);
    return unit(sheetNormal(mesh, triangle, across) + sheetNormal(mesh, across, triangle));
  }
  const bool creased = crease_cosine > kNoCrease;
  const Spoke start(mesh, triangle, mesh.triangles[triangle][corner]);
  Vec3 first = Vec3::Zero(), sum = first;
  const auto add = [&](const Spoke& spoke, Vec3& last) {
    if (spoke.isShut(0) || spoke.isShut(2)) return true;
    if (spoke.face.isThread()) {
      if (!creased) sum += sheetBeyond(mesh, spoke.face, spoke.triangle, spoke.corner);
      return true;
    }
    const Vec3 here = spoke.face.normal();
    if (!last.isZero(0) && here.dot(last) < crease_cosine) return false;
    last = here;
    sum += spoke.face.angle(spoke.corner) * here;
    return true;
  };
  add(start, first);
  for (const std::uint32_t side : {0u, 2u}) {  // Over the edge that leaves the vertex, or back over the one that comes.
    std::uint32_t vertex = 0;
    const std::uint32_t next = mesh.neighbours[triangle][start.exit(mesh, side, vertex)];
    std::uint32_t t = next;
    Vec3 last = first;
    for (int i = 0; i < kMaxFan && t != HD_NO_INDEX; ++i) {
      if (t == triangle || (i > 0 && t == next)) return unit(sum);  // All the way round.
      ++work;
      const Spoke spoke(mesh, t, vertex);
      if (!add(spoke, last)) break;
      t = mesh.neighbours[t][spoke.exit(mesh, side, vertex)];
    }
  }
  return unit(sum);
}

}  // namespace hapticd
