/** @file
 * The swept point against triangles: watertight edge tests after Woop, Benthin, Wald, "Watertight Ray/Triangle
 * Intersection", JCGT 2(1), 2013, in double precision, so that the two triangles of an edge decide alike on which side
 * of it the line passes; depths are taken from the triangle's plane, where they are most exact.
 */
#include <algorithm>
#include <cmath>

#include "rt/geometry/sweep.h"

namespace hapticd {
namespace {

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

bool sweepTriangle(const MeshView& mesh, std::uint32_t t, const Line& line, const Sweep& sweep, SweepHit& hit) HD_RT {
  const Vec3 v0 = mesh.vertex(t, 0), v1 = mesh.vertex(t, 1), v2 = mesh.vertex(t, 2);
  const Vec3 a = v0 - sweep.a, b = v1 - sweep.a, c = v2 - sweep.a;
  const double ax = a[line.x] - line.shear_x * a[line.z], ay = a[line.y] - line.shear_y * a[line.z];
  const double bx = b[line.x] - line.shear_x * b[line.z], by = b[line.y] - line.shear_y * b[line.z];
  const double cx = c[line.x] - line.shear_x * c[line.z], cy = c[line.y] - line.shear_y * c[line.z];
  // Exactly opposite for the neighbour, which sees each edge the other way round. Zero counts for both.
  const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  const bool front = u >= 0 && v >= 0 && w >= 0, back = u <= 0 && v <= 0 && w <= 0;
  if (!front && !(back && sweep.two_sided)) return false;

  Vec3 n = (v1 - v0).cross(v2 - v0);
  const double length = n.norm();
  if (length == 0) return false;
  n /= length;
  double approach = -n.dot(sweep.d), height = -n.dot(a);
  if (sweep.two_sided && approach < 0) {
    n = -n;
    approach = -approach;
    height = -height;
  }
  if (approach <= 0 || height < -sweep.tolerance || height >= approach) return false;
  const double time = std::max(height, 0.0) / approach;
  if (time >= hit.t) return false;
  hit = {time, height, n, n.dot(v0), t};
  return true;
}

/** Slab test: when the swept point may enter the box, or 2 if not before t_max. */
struct BoxTest {
  Vec3 a, inverse;
  double margin;

  explicit BoxTest(const Sweep& sweep) noexcept : a(sweep.a) {
    // A line may meet a triangle at a corner of its box: rounding must not part them.
    const double scale = std::max(sweep.a.cwiseAbs().maxCoeff(), (sweep.a + sweep.d).cwiseAbs().maxCoeff());
    margin = std::max(sweep.tolerance, 0x1p-49 * scale);
    for (int i = 0; i < 3; ++i) {
      // A finite stand-in for 1/0 keeps 0 * inf out; its slab is then either always or never.
      inverse[i] = std::abs(sweep.d[i]) > 1e-280 ? 1.0 / sweep.d[i] : (sweep.d[i] < 0 ? -1e280 : 1e280);
    }
  }

  double enter(const hd_bvh_node& node, double t_max) const HD_RT {
    double in = 0, out = t_max;
    for (int i = 0; i < 3; ++i) {
      const double t0 = (double{node.lower[i]} - margin - a[i]) * inverse[i];
      const double t1 = (double{node.upper[i]} + margin - a[i]) * inverse[i];
      in = std::max(in, std::min(t0, t1));
      out = std::min(out, std::max(t0, t1));
    }
    return in <= out ? in : 2.0;
  }
};

}  // namespace

SweepResult sweepMesh(const MeshView& mesh, Sweep& sweep, SweepHit& hit) HD_RT {
  if (mesh.node_count == 0 || sweep.d.isZero(0)) return SweepResult::kNone;
  const Line line(sweep.d);
  const BoxTest box(sweep);
  struct Entry {
    std::uint32_t node;
    double t;
  };
  Entry stack[HD_BVH_MAX_DEPTH + 1];
  std::uint32_t size = 0;
  bool found = false;
  ++sweep.work;
  if (const double t = box.enter(mesh.nodes[0], hit.t); t < 2.0) stack[size++] = {0, t};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.t > hit.t) continue;
    const hd_bvh_node& node = mesh.nodes[entry.node];
    if (node.count > 0) {
      sweep.work += node.count;
      for (std::uint32_t i = 0; i < node.count; ++i) {
        if (sweepTriangle(mesh, node.first + i, line, sweep, hit)) found = true;
      }
    } else {
      sweep.work += 2;
      Entry near{node.first, box.enter(mesh.nodes[node.first], hit.t)};
      Entry far{node.first + 1, box.enter(mesh.nodes[node.first + 1], hit.t)};
      if (far.t < near.t) std::swap(near, far);
      if (far.t < 2.0) stack[size++] = far;
      if (near.t < 2.0) stack[size++] = near;
    }
    if (sweep.work > sweep.limit) return SweepResult::kExhausted;
  }
  return found ? SweepResult::kHit : SweepResult::kNone;
}

}  // namespace hapticd
