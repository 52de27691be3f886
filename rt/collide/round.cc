#include "rt/collide/round.h"

#include <algorithm>

#include "rt/collide/tool_points.h"

namespace hapticd {
namespace {

bool isRound(const Shape& shape) HD_RT { return shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule; }

/** Half as long as a capsule's axis; a sphere has none. */
double halfAxis(const Shape& shape) HD_RT { return shape.kind == ShapeKind::kCapsule ? shape.size.y() : 0; }

/** Of radius 0: a point. */
struct Ball {
  Vec3 center;
  double radius;
};

}  // namespace

void rollTo(const RoundBody& a, std::uint32_t feature, const RoundBody& b, const Vec3& com_W, const Vec3& w_B,
            Touch& touch) HD_RT {
  if (!isRound(a.shape) && !isRound(b.shape)) return;
  const Vec3 before = com_W + touch.r_a;
  Ball x{before, 0};
  if (isRound(a.shape)) {
    x = {a.X_WO * Vec3(0, 0, ToolPoints::alongAxis(feature, halfAxis(a.shape))), a.shape.size.x()};
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
