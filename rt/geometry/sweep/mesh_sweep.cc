/** @file
 * The swept point against triangles: watertight edge tests after Woop, Benthin, Wald, "Watertight Ray/Triangle
 * Intersection", JCGT 2(1), 2013, in double precision, so that the two triangles of an edge decide alike on which side
 * of it the line passes; depths are taken from the triangle's plane, where they are most exact.
 */
#include <algorithm>
#include <cmath>

#include "rt/geometry/sweep/sweep_triangles.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

/**
 * Of the tolerance: what leaves a two-sided triangle would else be held as what has come through it. Still 64 times
 * what rounding does to coordinates.
 */
constexpr double kOfTwoSided = 0.125;

/** The swept line in sheared axes: along z it runs, x and y are what the edge tests see. */
struct Line {
  int x, y, z;
  double shear_x, shear_y;

  explicit Line(const Vec3& d) noexcept {
    z = std::abs(d.x()) > std::abs(d.y()) ? (std::abs(d.x()) > std::abs(d.z()) ? 0 : 2)
                                          : (std::abs(d.y()) > std::abs(d.z()) ? 1 : 2);
    x = (z + 1) % 3;
    y = (x + 1) % 3;
    if (d[z] < 0) std::swap(x, y);  // Keeps the winding.
    shear_x = d[x] / d[z];
    shear_y = d[y] / d[z];
  }
};

void sweepTriangle(const MeshView& mesh, std::uint32_t t, const Line& line, const Sweep& sweep, Earliest& first) HD_RT {
  const Vec3 v0 = mesh.vertex(t, 0), v1 = mesh.vertex(t, 1), v2 = mesh.vertex(t, 2);
  const Vec3 a = v0 - sweep.a, b = v1 - sweep.a, c = v2 - sweep.a;
  const double ax = a[line.x] - line.shear_x * a[line.z], ay = a[line.y] - line.shear_y * a[line.z];
  const double bx = b[line.x] - line.shear_x * b[line.z], by = b[line.y] - line.shear_y * b[line.z];
  const double cx = c[line.x] - line.shear_x * c[line.z], cy = c[line.y] - line.shear_y * c[line.z];
  // Exactly opposite for the neighbour, which sees each edge the other way round. Zero counts for both.
  const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  const bool front = u >= 0 && v >= 0 && w >= 0, back = u <= 0 && v <= 0 && w <= 0;
  if (!front && !(back && sweep.two_sided)) return;

  Vec3 n = areaVector(v1 - v0, v2 - v0);
  const double length = n.norm();
  if (length == 0) return;
  n /= length;
  double approach = -n.dot(sweep.d), height = -n.dot(a);
  if (sweep.two_sided && approach < 0) {
    n = -n;
    approach = -approach;
    height = -height;
  }
  // A sweep never ends exactly on a triangle: on a two-sided one the side would be unknown, and a point exactly in
  // the wall of a one-sided mesh is not above the floor that ends at that wall.
  const double behind = (sweep.two_sided ? kOfTwoSided : 1) * sweep.tolerance;
  if (approach <= 0 || height < -behind || height >= approach + sweep.tolerance) return;
  const double time = std::min(std::max(height, 0.0) / approach, kAtEnd);
  if (!first.isBeatenBy(time, t)) return;
  first.set({time, height, n, n.dot(v0), t, FeatureKind::kFace, 0, Vec3::Zero()});
}

}  // namespace

SweepResult sweepMesh(const MeshView& mesh, Sweep& sweep, SweepHit& hit) HD_RT {
  if (sweep.d.isZero(0)) return SweepResult::kNone;
  if (sweep.radius > 0) return sweepBallOverMesh(mesh, sweep, hit);
  const Line line(sweep.d);
  return sweepTriangles(mesh, sweep, hit,
                        [&](std::uint32_t t, Earliest& first) { sweepTriangle(mesh, t, line, sweep, first); });
}

}  // namespace hapticd
