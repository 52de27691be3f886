#include <algorithm>

#include "rt/geometry/sweep.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

Vec3 fromFloats(const float (&x)[3]) HD_RT { return {x[0], x[1], x[2]}; }

struct Triangle {
  Vec3 v[3];

  /** Not scaled: twice the area long. */
  [[nodiscard]] Vec3 normal() const HD_RT { return areaVector(v[1] - v[0], v[2] - v[0]); }
  /** Whether x, seen along the normal, is within the triangle or a hair beside it. */
  [[nodiscard]] bool covers(const Vec3& x) const HD_RT {
    constexpr double kHair = 1e-9;  // Neighbours overlap.
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

/**
 * When, in [0, 1], the plane of a triangle of which one corner moves comes to a ball about x from that side; x is
 * outside before, by rounding at least, and behind it after. n . (x - v) and n are linear in time, so it is a quadratic
 * equation, v0 + t dv = r |n0 + t dn| squared; with their difference concave, it happens once.
 */
double meeting(const Vec3& n0, const Vec3& n1, double v0, double v1, double radius) HD_RT {
  const Vec3 dn = n1 - n0;
  const double dv = v1 - v0, r2 = radius * radius;
  const double b = v0 * dv - r2 * n0.dot(dn);
  const double c = v0 * v0 - r2 * n0.squaredNorm();
  // (b b - a c) / (r r), of the equation a t t + 2 b t + c = 0.
  const double root2 = (dv * n0 - v0 * dn).squaredNorm() - r2 * n0.cross(dn).squaredNorm();
  const double below = -b + radius * std::sqrt(std::max(0.0, root2));
  return c > 0 && below > 0 ? std::min(c / below, 1.0) : 0.0;
}

/** As overtakes(), of the ball against the face alone. */
bool faceOvertakes(const TriangleMove& move, bool two_sided, double tolerance, Vec3& x, double radius) HD_RT {
  const Triangle before{{fromFloats(move.before[0]), fromFloats(move.before[1]), fromFloats(move.before[2])}};
  Triangle after = before;
  after.v[move.corner] = fromFloats(move.after);
  const Vec3 n0 = before.normal(), n1 = after.normal();
  const double area0 = n0.norm(), area1 = n1.norm();
  if (area0 == 0 || area1 == 0) return false;
  double v0 = n0.dot(x - before.v[0]), v1 = n1.dot(x - after.v[0]);
  const double side = two_sided && v0 < 0 ? -1 : 1;
  v0 *= side;
  v1 *= side;
  const double h0 = v0 / area0 - radius, h1 = v1 / area1 - radius;
  if (h0 < -tolerance || h1 >= 0 || h1 >= h0) return false;
  const double t = meeting(n0, n1, v0, v1, radius);
  const Vec3 way = after.v[move.corner] - before.v[move.corner];
  Triangle then = before;
  then.v[move.corner] += t * way;
  if (!then.covers(x)) return false;
  // On with the point of the surface that has reached it, so that it comes to lie on this triangle and no other.
  x += (1 - t) * std::clamp(then.weight(move.corner, x), 0.0, 1.0) * way;
  x += (side * (radius + tolerance) - n1.dot(x - after.v[0]) / area1) / area1 * n1;
  return true;
}

}  // namespace

bool overtakes(const TriangleMove& move, bool two_sided, double tolerance, Vec3& x, double radius) HD_RT {
  // Beside the face the ball gives way, as far as its centre.
  return faceOvertakes(move, two_sided, tolerance, x, radius) ||
         (radius > 0 && faceOvertakes(move, two_sided, tolerance, x, 0));
}

}  // namespace hapticd
