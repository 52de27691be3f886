#include "rt/geometry/triangle.h"

#include <algorithm>

namespace hapticd {
namespace {

/** p / (p + q) for p, q >= 0; 0 if both are. */
double share(double p, double q) HD_RT { return p > 0 ? p / (p + q) : 0.0; }

/**
 * What rounding takes from the product (Dekker, "A floating-point technique for extending the available precision",
 * Numerische Mathematik 18, 1971).
 */
double lostIn(double product, double x, double y) HD_RT {
  constexpr double kHalf = 0x1p27 + 1;  // Splits a number into two of 26 digits.
  const double x_big = kHalf * x, y_big = kHalf * y;
  const double x_high = x_big - (x_big - x), y_high = y_big - (y_big - y);
  const double x_low = x - x_high, y_low = y - y_high;
  return x_low * y_low - (((product - x_high * y_high) - x_low * y_high) - x_high * y_low);
}

/** a b - c d, exact to rounding. */
double differenceOfProducts(double a, double b, double c, double d) HD_RT {
  const double ab = a * b, cd = c * d;
  return (ab - cd) + (lostIn(ab, a, b) - lostIn(cd, c, d));
}

/** The point of the edge from corner k nearest to x. */
TriangleFoot nearestOnEdge(const Vec3 (&v)[3], std::uint32_t k, const Vec3& x) HD_RT {
  const std::uint32_t next = (k + 1) % 3;
  const Vec3 along = v[next] - v[k];
  const double part = along.dot(x - v[k]), whole = along.squaredNorm();
  if (!(part > 0)) return {v[k], FeatureKind::kVertex, k};
  if (part >= whole) return {v[next], FeatureKind::kVertex, next};
  return {v[k] + part / whole * along, FeatureKind::kEdge, k};
}

/** Of a needle, in whose plane products of lengths tell nothing. */
TriangleFoot nearestOnNeedle(const Corners& triangle, const Vec3& x) HD_RT {
  const Vec3 v[3] = {triangle.a, triangle.b, triangle.c};
  const Vec3 n = triangle.normal();
  const double nn = n.squaredNorm();
  bool over = nn > 0;
  for (std::uint32_t k = 0; k < 3; ++k) over = over && (v[(k + 1) % 3] - v[k]).cross(x - v[k]).dot(n) >= 0;
  if (over) return {x - n.dot(x - v[0]) / nn * n, FeatureKind::kFace, 0};
  TriangleFoot nearest = nearestOnEdge(v, 0, x);
  for (const std::uint32_t k : {1u, 2u}) {
    const TriangleFoot foot = nearestOnEdge(v, k, x);
    if ((foot.point - x).squaredNorm() < (nearest.point - x).squaredNorm()) nearest = foot;
  }
  return nearest;
}

}  // namespace

Vec3 areaVectorOfNeedle(const Vec3& one, const Vec3& other) HD_RT {
  return {differenceOfProducts(one.y(), other.z(), one.z(), other.y()),
          differenceOfProducts(one.z(), other.x(), one.x(), other.z()),
          differenceOfProducts(one.x(), other.y(), one.y(), other.x())};
}

TriangleFoot nearestOnTriangle(const Corners& triangle, const Vec3& x) HD_RT {
  const Vec3 &a = triangle.a, &b = triangle.b, &c = triangle.c;
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 ax = x - a, bx = x - b, cx = x - c;
  const double a1 = ab.dot(ax), a2 = ac.dot(ax);
  if (a1 <= 0 && a2 <= 0) return {a, FeatureKind::kVertex, 0};
  const double b1 = ab.dot(bx), b2 = ac.dot(bx);
  if (b1 >= 0 && b2 <= b1) return {b, FeatureKind::kVertex, 1};
  const double c1 = ab.dot(cx), c2 = ac.dot(cx);
  if (c2 >= 0 && c1 <= c2) return {c, FeatureKind::kVertex, 2};
  const double ab2 = a1 - b1, ac2 = a2 - c2, common = a2 - b2;
  const double longest2 = std::max({ab2, ac2, ab2 + ac2 - 2 * common});
  if (!(ab2 * ac2 - common * common >= kNeedle2 * longest2 * longest2)) return nearestOnNeedle(triangle, x);
  const double w = a1 * b2 - b1 * a2;
  if (w <= 0 && a1 >= 0 && b1 <= 0) return {a + share(a1, -b1) * ab, FeatureKind::kEdge, 0};
  const double v = c1 * a2 - a1 * c2;
  if (v <= 0 && a2 >= 0 && c2 <= 0) return {a + share(a2, -c2) * ac, FeatureKind::kEdge, 2};
  const double u = b1 * c2 - c1 * b2;
  if (u <= 0 && b2 >= b1 && c1 >= c2) return {b + share(b2 - b1, c1 - c2) * (c - b), FeatureKind::kEdge, 1};
  const double sum = u + v + w;
  return {a + ab * (v / sum) + ac * (w / sum), FeatureKind::kFace, 0};
}

}  // namespace hapticd
