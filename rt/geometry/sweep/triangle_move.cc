#include <algorithm>

#include "rt/geometry/sweep/sweep.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kHair = 1e-9;  // Of a triangle: neighbours overlap.

Vec3 cornerAt(const float (&x)[3]) HD_RT { return {x[0], x[1], x[2]}; }

struct Triangle {
  Vec3 v[3];

  /** Not scaled: twice the area long. */
  [[nodiscard]] Vec3 normal() const HD_RT { return areaVector(v[1] - v[0], v[2] - v[0]); }
  /** Whether x, seen along the normal, is within the triangle or a hair beside it. */
  [[nodiscard]] bool covers(const Vec3& x) const HD_RT {
    return weight(0, x) >= -kHair && weight(1, x) >= -kHair && weight(2, x) >= -kHair;
  }
  /** Barycentric coordinate of x, seen along the normal, that belongs to corner c. */
  [[nodiscard]] double weight(std::uint32_t c, const Vec3& x) const HD_RT {
    const Vec3 n = normal();
    const double nn = n.squaredNorm();
    const Vec3 &a = v[(c + 1) % 3], &b = v[(c + 2) % 3];
    return nn > 0 ? (b - a).cross(x - a).dot(n) / nn : -1.0;
  }
};

Triangle before(const TriangleMove& move) HD_RT {
  return {{cornerAt(move.before[0]), cornerAt(move.before[1]), cornerAt(move.before[2])}};
}

Triangle after(const TriangleMove& move) HD_RT {
  Triangle moved = before(move);
  moved.v[move.corner] = cornerAt(move.after);
  return moved;
}

}  // namespace

Vec3 takenAlong(const TriangleMove& move, double weight, const Vec3& x) HD_RT {
  const Triangle was = before(move), is = after(move);
  Vec3 to = x + weight * (is.v[move.corner] - was.v[move.corner]);
  const Vec3 n0 = was.normal(), n1 = is.normal();
  const double area0 = n0.norm(), area1 = n1.norm();
  if (area0 == 0 || area1 == 0) return to;
  return to + n0.dot(x - was.v[0]) / area0 * (n1 / area1 - n0 / area0);
}

bool covers(const Corners& triangle, const Vec3& x) HD_RT {
  return Triangle{{triangle.a, triangle.b, triangle.c}}.covers(x);
}

bool overtakes(const TriangleMove& move, int side, double skin, Vec3& x) HD_RT {
  const Triangle before = hapticd::before(move), after = hapticd::after(move);
  const Vec3 n1 = after.normal();
  const double v1 = side * n1.dot(x - after.v[0]);
  if (v1 >= 0) return false;
  const Vec3 n0 = before.normal();
  const double area0 = n0.norm(), area1 = n1.norm();
  if (area0 == 0 || area1 == 0) return false;
  const double v0 = side * n0.dot(x - before.v[0]);
  if (v0 < -kLiesOn * skin * area0) {  // An earlier push led x through it.
    if (!after.covers(x)) return false;
  } else {
    if (v1 / area1 >= v0 / area0) return false;
    // One corner on a straight way: the volume below x is linear in time.
    const Vec3 way = cornerAt(move.after) - cornerAt(move.before[move.corner]);
    const double t = v0 > 0 ? v0 / (v0 - v1) : 0.0;
    Triangle then = before;
    then.v[move.corner] += t * way;
    if (!then.covers(x)) return false;
    // Carry x along with the surface point that reached it, so that it ends on this triangle and on no other.
    x += (1 - t) * std::clamp(then.weight(move.corner, x), 0.0, 1.0) * way;
  }
  x += (side * skin - n1.dot(x - after.v[0]) / area1) / area1 * n1;
  return true;
}

}  // namespace hapticd
