#include "rt/collide/round.h"

#include <algorithm>
#include <cmath>

#include "rt/collide/tool_points.h"

namespace hapticd {
namespace {

bool isRound(const Shape& shape) HD_RT { return shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule; }

/** Half as long as a capsule's axis; a sphere has none. */
double halfAxis(const Shape& shape) HD_RT { return shape.kind == ShapeKind::kCapsule ? shape.size.y() : 0; }

/**
 * Of a cylinder's mantle the point that lies lowest over the plane, within a quarter turn of the one that was tried
 * where it lies on its side, and the less far the more upright it stands: on its end it has points all around.
 */
Vec3 roundAbout(const Shape& shape, const Pose& X_WO, const Vec3& point_W, const Vec3& n_W) HD_RT {
  const Vec3 p = X_WO.inverse() * point_W;
  const Vec3 down = X_WO.q.conjugate() * -n_W;
  const double radius = p.head<2>().norm(), flat = down.head<2>().norm();
  if (radius < 0.75 * shape.size.x() || !(flat > 0)) return point_W;  // on an end, within the rim; or upright
  const double c = std::max(0.0, 1 - flat * flat);                    // of the most that it may turn about the axis
  if (p.head<2>().dot(down.head<2>()) >= c * radius * flat) {
    const double r = radius / flat;
    return X_WO * Vec3(r * down.x(), r * down.y(), p.z());
  }
  const double s = std::copysign(std::sqrt(1 - c * c), p.x() * down.y() - p.y() * down.x());
  return X_WO * Vec3(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z());
}

/** Of radius 0: a point. */
struct Ball {
  Vec3 center;
  double radius;
};

}  // namespace

void rollTo(const RoundBody& a, std::uint32_t feature, const RoundBody& b, const Vec3& com_W, const Vec3& w_B,
            Touch& touch) HD_RT {
  const bool mantle = a.shape.kind == ShapeKind::kCylinder;
  if (!isRound(a.shape) && !isRound(b.shape) && !mantle) return;
  const Vec3 before = com_W + touch.r_a;
  Ball x{before, 0};
  if (isRound(a.shape)) {
    x = {a.X_WO * Vec3(0, 0, ToolPoints::alongAxis(feature, halfAxis(a.shape))), a.shape.size.x()};
  } else if (mantle) {
    x.center = roundAbout(a.shape, a.X_WO, before, touch.n);
  }
  if (isRound(b.shape)) {
    const double half = halfAxis(b.shape);
    const double along = (b.X_WO.inverse() * x.center).z();
    const Vec3 way = x.center - b.X_WO * Vec3(0, 0, std::clamp(along, -half, half));
    const double apart = way.norm();
    // What has passed B's middle is pushed back to where it came from: the plane knows.
    if (!(way.dot(touch.n) > 0.5 * apart)) return;
    touch.n = way / apart;
    touch.gap = apart - x.radius - b.shape.size.x();
  } else {
    touch.gap += touch.n.dot(x.center - x.radius * touch.n - before);
  }
  touch.r_a = x.center - x.radius * touch.n - com_W;
  touch.moving += w_B.cross(com_W + touch.r_a - before);
}

}  // namespace hapticd
