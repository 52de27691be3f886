#include <algorithm>

#include "rt/geometry/sweep.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kHair = 1e-9;  // Of a triangle: neighbours overlap.
constexpr double kAround = 4;   // Than ways: where a triangle tilts.
constexpr double kLiesOn = 64;  // Tolerances.
constexpr double kClear = 2;    // Tolerances: in one, two-sided triangles would hold the point from either side.

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

/** Whether x is farther from all places of the triangle than this, along one axis. Most are, and nothing else is asked.
 */
bool isFar(const TriangleMove& move, const Vec3& x, double distance) HD_RT {
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax({move.before[0][k], move.before[1][k], move.before[2][k], move.after[k]});
    const double beside = distance + kAround * kHair * (double{high} - low);
    if (x[k] < low - beside || x[k] > high + beside) return true;
  }
  return false;
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

bool isInFront(const TriangleMove& move, const Vec3& x, double tolerance) HD_RT {
  const Triangle triangle = before(move);
  const Vec3 n = triangle.normal();
  return n.dot(x - triangle.v[0]) >= -tolerance * n.norm();
}

Overtaking overtakes(const TriangleMove& move, MetFrom met, double tolerance, const Vec3& from, Vec3& x) HD_RT {
  const Vec3 way = cornerAt(move.after) - cornerAt(move.before[move.corner]);
  // What a neighbour has carried past this triangle is no farther from it than both ways.
  if (isFar(move, x, kAround * (way.norm() + (x - from).norm() + kClear * tolerance))) return Overtaking::kNone;
  const Triangle before = hapticd::before(move), after = hapticd::after(move);
  const double above = (met.two_sided ? kClear : 1) * tolerance;
  const Vec3 n0 = before.normal(), n1 = after.normal();
  const double area0 = n0.norm(), area1 = n1.norm();
  if (area0 == 0 || area1 == 0) return Overtaking::kNone;
  const double was = n0.dot(from - before.v[0]);
  const bool near = std::abs(was) <= kLiesOn * tolerance * area0, lies_on = near && met.on != 0;
  const double side = !met.two_sided ? 1 : (lies_on ? met.on : (was < 0 ? -1 : 1));
  const double v0 = side * n0.dot(x - before.v[0]), v1 = side * n1.dot(x - after.v[0]);
  if (v1 >= 0) return Overtaking::kNone;
  if (side * was / area0 < -tolerance && !(lies_on && !met.two_sided))
    return near && !met.two_sided ? Overtaking::kUnsure : Overtaking::kNone;
  if (v0 / area0 < -tolerance) {  // A neighbour has carried it past where this triangle was, and into it.
    if (!after.covers(x)) return Overtaking::kNone;
  } else {
    if (v1 / area1 >= v0 / area0) return Overtaking::kNone;
    // One corner on a straight way: the volume below x is linear in time.
    const double t = v0 > 0 ? v0 / (v0 - v1) : 0.0;
    Triangle then = before;
    then.v[move.corner] += t * way;
    if (!then.covers(x)) return Overtaking::kNone;
    // On with the point of the surface that has reached it, so that it comes to lie on this triangle and no other.
    x += (1 - t) * std::clamp(then.weight(move.corner, x), 0.0, 1.0) * way;
  }
  x += (side * above - n1.dot(x - after.v[0]) / area1) / area1 * n1;
  return Overtaking::kDone;
}

}  // namespace hapticd
