#include <algorithm>
#include <cmath>
#include <limits>

#include "rt/geometry/sweep/sweep.h"

namespace hapticd {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/** Times at which the swept line is inside one convex constraint of a solid, and how high above it the start is. */
struct Inside {
  double in = -kInfinity;
  double out = kInfinity;
  double height = -kInfinity;
  bool never = false;
};

/**
 * |x| <= half on one axis, x = a + t d. What stays in one of its planes belongs to it on one side and not on the other:
 * of two boxes side by side just one meets who is exactly between, and who slides in their upper planes meets neither.
 * Who comes to within the tolerance of a plane meets it: nobody is left exactly in one.
 */
Inside slab(double a, double d, double half, double tolerance) HD_RT {
  Inside r;
  if (d == 0) {
    r.never = a >= half || a < -half;
    return r;
  }
  const double s = d > 0 ? 1.0 : -1.0;
  r.height = -s * a - half;
  r.in = r.height / std::abs(d);
  if (r.in > kAtEnd && r.height - std::abs(d) <= tolerance) r.in = kAtEnd;
  r.out = (half - s * a) / std::abs(d);
  return r;
}

/** |x| <= radius in the space of the vectors (2-D: cylinder about z, 3-D: ball). */
template <class Vector>
Inside round(const Vector& a, const Vector& d, double radius) HD_RT {
  Inside r;
  const double dd = d.squaredNorm();
  const double distance = a.norm();
  if (dd == 0) {
    r.never = distance >= radius;
    return r;
  }
  const double ad = a.dot(d);
  const Vector foot = a - d * (ad / dd);  // Without the cancellation of ad^2 - dd (aa - rr).
  const double disc = (radius - foot.norm()) * (radius + foot.norm()) * dd;
  if (disc <= 0) {
    r.never = true;
    return r;
  }
  r.height = distance - radius;
  const double c = r.height * (distance + radius);
  const double root = std::sqrt(disc);
  r.in = ad < 0 ? c / (root - ad) : (-ad - root) / dd;
  r.out = ad < 0 ? (root - ad) / dd : -c / (root + ad);
  return r;
}

/**
 * Whether a convex solid bounded by constraints is entered through the one that lets in last. A start within the
 * tolerance behind it still enters, at t = 0; one deeper is inside already.
 */
bool enters(const Inside& last, double out, const Sweep& sweep, double t_max) HD_RT {
  return last.in < t_max && last.in < out && out > 0 && last.height >= -sweep.tolerance;
}

SweepHit found(double t, double height, const Vec3& normal, double offset, std::uint32_t feature = 0) HD_RT {
  SweepHit hit;
  hit.t = t;
  hit.height = height;
  hit.normal = normal;
  hit.offset = offset;
  hit.feature = feature;
  return hit;
}

}  // namespace

bool sweepPlane(const Sweep& sweep, SweepHit& hit) HD_RT {
  const double a = sweep.a.z(), d = sweep.d.z();
  if (d >= 0 || a < -sweep.tolerance || a + d > sweep.tolerance) return false;
  const double t = std::min(std::max(a, 0.0) / -d, kAtEnd);
  if (t >= hit.t) return false;
  hit = found(t, a, Vec3::UnitZ(), 0);
  return true;
}

bool sweepSphere(double radius, const Sweep& sweep, SweepHit& hit) HD_RT {
  const Inside r = round(sweep.a, sweep.d, radius);
  if (r.never || sweep.a.dot(sweep.d) >= 0 || !enters(r, r.out, sweep, hit.t)) return false;
  const double t = std::max(r.in, 0.0);
  const Vec3 n = (sweep.a + t * sweep.d).normalized();
  hit = found(t, r.height, n, radius);
  return true;
}

bool sweepBox(const Vec3& half, const Sweep& sweep, SweepHit& hit) HD_RT {
  Inside last;
  double out = kInfinity;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const Inside r = slab(sweep.a[i], sweep.d[i], half[i], sweep.tolerance);
    if (r.never) return false;
    out = std::min(out, r.out);
    if (r.in > last.in) {
      last = r;
      axis = i;
    }
  }
  if (!enters(last, out, sweep, hit.t)) return false;
  const bool positive = sweep.d[axis] < 0;
  hit = found(std::max(last.in, 0.0), last.height, Vec3::Unit(axis) * (positive ? 1.0 : -1.0), half[axis],
              static_cast<std::uint32_t>(2 * axis + (positive ? 0 : 1)));
  return true;
}

bool sweepCapsule(double radius, double half, const Sweep& sweep, SweepHit& hit) HD_RT {
  const auto axisPoint = [half](const Vec3& x) { return Vec3(0, 0, std::clamp(x.z(), -half, half)); };
  const Vec3 from = sweep.a - axisPoint(sweep.a);
  const double height = from.norm() - radius;
  if (height < -sweep.tolerance) return false;
  double t = hit.t;
  bool entered = false;
  const auto consider = [&](double in) {
    if (in >= t) return;
    t = std::max(in, 0.0);
    entered = true;
  };
  const Inside side = round(Eigen::Vector2d(sweep.a.head<2>()), Eigen::Vector2d(sweep.d.head<2>()), radius);
  if (!side.never && enters(side, side.out, sweep, t) && sweep.a.head<2>().dot(sweep.d.head<2>()) < 0 &&
      std::abs(sweep.a.z() + std::max(side.in, 0.0) * sweep.d.z()) <= half) {
    consider(side.in);
  }
  for (const double z : {-half, half}) {
    const Vec3 a = sweep.a - Vec3(0, 0, z);
    const Inside end = round(a, sweep.d, radius);
    if (!end.never && enters(end, end.out, sweep, t) && a.dot(sweep.d) < 0) consider(end.in);
  }
  if (!entered) return false;
  const Vec3 x = sweep.a + t * sweep.d;
  const Vec3 c = axisPoint(x);
  const Vec3 n = (x - c).normalized();
  hit = found(t, height, n, n.dot(c) + radius);
  return true;
}

bool sweepCylinder(double radius, double half, const Sweep& sweep, SweepHit& hit) HD_RT {
  const Inside side = round(Eigen::Vector2d(sweep.a.head<2>()), Eigen::Vector2d(sweep.d.head<2>()), radius);
  const Inside cap = slab(sweep.a.z(), sweep.d.z(), half, sweep.tolerance);
  if (side.never || cap.never) return false;
  const bool by_cap = cap.in > side.in;
  const Inside& last = by_cap ? cap : side;
  if (!enters(last, std::min(side.out, cap.out), sweep, hit.t)) return false;
  const double t = std::max(last.in, 0.0);
  if (by_cap) {
    const bool top = sweep.d.z() < 0;
    hit = found(t, cap.height, Vec3::UnitZ() * (top ? 1.0 : -1.0), half, top ? 1u : 2u);
  } else {
    if (sweep.a.head<2>().dot(sweep.d.head<2>()) >= 0) return false;
    const Vec3 x = sweep.a + t * sweep.d;
    hit = found(t, side.height, Vec3(x.x(), x.y(), 0).normalized(), radius);
  }
  return true;
}

bool tangentNearest(const Shape& shape, std::uint32_t feature, const Vec3& x, Vec3& normal, double& offset,
                    double grown) HD_RT {
  if (!isCurved(shape, feature)) return false;
  Vec3 c = Vec3::Zero();
  if (shape.kind == ShapeKind::kCapsule) c.z() = std::clamp(x.z(), -shape.size.y(), shape.size.y());
  if (shape.kind == ShapeKind::kCylinder) c.z() = x.z();
  const Vec3 r = x - c;
  const double length = r.norm();
  if (length < 1e-9 * shape.size.x()) return false;
  normal = r / length;
  offset = normal.dot(c) + shape.size.x() + grown;
  return true;
}

Ball boundingBall(const Shape& shape) HD_RT {
  switch (shape.kind) {
    case ShapeKind::kPlane:
      return {Vec3::Zero(), kInfinity};
    case ShapeKind::kSphere:
      return {Vec3::Zero(), shape.size.x()};
    case ShapeKind::kBox:
      return {Vec3::Zero(), shape.size.norm()};
    case ShapeKind::kCapsule:
      return {Vec3::Zero(), shape.size.x() + shape.size.y()};
    case ShapeKind::kCylinder:
      return {Vec3::Zero(), std::hypot(shape.size.x(), shape.size.y())};
    case ShapeKind::kMesh: {
      if (!shape.mesh || shape.mesh->node_count == 0) return {};
      const hd_bvh_node& root = shape.mesh->nodes[0];
      Vec3 lower, upper;
      for (int k = 0; k < 3; ++k) {
        lower[k] = *std::min_element(root.lower[k], root.lower[k] + root.used);
        upper[k] = *std::max_element(root.upper[k], root.upper[k] + root.used);
      }
      return {(lower + upper) / 2, (upper - lower).norm() / 2};
    }
    case ShapeKind::kGroup:
      break;
  }
  return {};
}

}  // namespace hapticd
