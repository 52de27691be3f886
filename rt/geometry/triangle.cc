#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

/** p / (p + q) for p, q >= 0; 0 if both are. */
double share(double p, double q) HD_RT { return p > 0 ? p / (p + q) : 0.0; }

}  // namespace

TriangleFoot nearestOnTriangle(const Corners& triangle, const Vec3& x) HD_RT {
  const Vec3 &a = triangle.a, &b = triangle.b, &c = triangle.c;
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 ax = x - a, bx = x - b, cx = x - c;
  const double a1 = ab.dot(ax), a2 = ac.dot(ax);
  if (a1 <= 0 && a2 <= 0) return {a, FeatureKind::kVertex, 0};
  const double b1 = ab.dot(bx), b2 = ac.dot(bx);
  if (b1 >= 0 && b2 <= b1) return {b, FeatureKind::kVertex, 1};
  const double w = a1 * b2 - b1 * a2;
  if (w <= 0 && a1 >= 0 && b1 <= 0) return {a + share(a1, -b1) * ab, FeatureKind::kEdge, 0};
  const double c1 = ab.dot(cx), c2 = ac.dot(cx);
  if (c2 >= 0 && c1 <= c2) return {c, FeatureKind::kVertex, 2};
  const double v = c1 * a2 - a1 * c2;
  if (v <= 0 && a2 >= 0 && c2 <= 0) return {a + share(a2, -c2) * ac, FeatureKind::kEdge, 2};
  const double u = b1 * c2 - c1 * b2;
  if (u <= 0 && b2 >= b1 && c1 >= c2) return {b + share(b2 - b1, c1 - c2) * (c - b), FeatureKind::kEdge, 1};
  const double sum = u + v + w;
  return {a + ab * (v / sum) + ac * (w / sum), FeatureKind::kFace, 0};
}

}  // namespace hapticd
