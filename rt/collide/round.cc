#include "rt/collide/round.h"

#include <algorithm>
#include <cmath>

#include "rt/collide/feature.h"
#include "rt/collide/mantle.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

/** Sine of a tilt over which a plane on a cylinder is on its end. */
constexpr double kUpright = 0.7;
constexpr std::uint32_t kOnePrimitive = 1;  ///< Work.

/** What has passed B's middle is pushed back to where it came from: the plane knows. */
bool sameSide(const Vec3& now, const Vec3& before) HD_RT { return now.dot(before) > 0.5 * now.norm(); }

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
struct BallOfA {
  Vec3 center;
  double radius;
};

/** From a ball about a cylinder's axis to the disc there, against the plane that A is: false where A meets an end. */
bool toDisc(const RoundBody& b, const Vec3& center, double distance, BallTouch& touch) HD_RT {
  const double radius = b.shape.size.x();
  const Vec3 axis = b.X_WO.q * Vec3::UnitZ();
  const Vec3 across = touch.n - axis.dot(touch.n) * axis;
  const double share = across.norm();
  const Vec3 p = b.X_WO.inverse() * touch.p_A;
  const double within = b.shape.size.y() - std::abs(p.z());
  if (!(share > kUpright) || within < 0 || within < radius - p.head<2>().norm()) return false;
  touch.gap = distance - radius * share;
  touch.p_A = center + radius / share * across + touch.gap * touch.n;
  return true;
}

/** A's surface moves along B's axis, or B's ball along A's surface. */
void meetAgain(const RoundBody& a, const RoundBody& b, const Vec3& com_W, const Vec3& w_B, Touch& touch) HD_RT {
  const Vec3 before = com_W + touch.r_a;
  NearestQuery query;
  query.limit = kOnePrimitive;
  BallTouch now;
  if (meetBall(a, b, onAxis(b, before), query, now) != NearestResult::kFound || !sameSide(now.n, touch.n)) return;
  touch.n = now.n;
  touch.gap = now.gap;
  touch.r_a = now.p_A - com_W;
  touch.moving += w_B.cross(now.p_A - before);
}

/** A's mantle turns and moves along, B's corner or edge as well. */
void meetMantleAgain(const RoundBody& a, std::uint32_t feature, const RoundBody& b, const Vec3& com_W, const Vec3& w_B,
                     Touch& touch) HD_RT {
  ObstacleEdge edge;
  MantleTouch now;
  const Vec3 before = com_W + touch.r_a;
  if (!edgeOfFeature(b.shape, feature, edge)) return;
  const Pose X_AB = a.X_WO.inverse() * b.X_WO;
  if (meetMantle(a.shape, edge, X_AB, b.X_WO.inverse() * before, now) != MantleMeeting::kMet) return;
  const Vec3 n = a.X_WO.q * now.n;
  if (!sameSide(n, touch.n)) return;
  touch.n = n;
  touch.gap = now.gap;
  touch.r_a = a.X_WO * now.x + now.gap * n - com_W;
  touch.moving += w_B.cross(com_W + touch.r_a - before);
}

/** Of boxes and cylinders what is nearest to a ball is told by one question, and turns as the ball goes over an edge.
 */
bool isEdged(const Shape& shape) HD_RT { return shape.kind == ShapeKind::kBox || shape.kind == ShapeKind::kCylinder; }

/** From B's surface where that is nearest to a ball of A; false: stays as it was. */
bool ballOnPrimitive(const BallOfA& ball, const RoundBody& b, Touch& touch) HD_RT {
  NearestQuery query;
  query.x = b.X_WO.inverse() * ball.center;
  query.limit = kOnePrimitive;
  Nearest nearest;
  if (nearestOnShape(b.shape, query, nearest) != NearestResult::kFound) return false;
  const double apart = std::sqrt(nearest.squared_distance), gap = nearest.isInside(query.x) ? -apart : apart;
  const Vec3 n = b.X_WO.q * (apart > 1e-7 ? Vec3((query.x - nearest.point) / gap) : nearest.pseudo_normal);
  if (!sameSide(n, touch.n)) return false;
  touch.n = n;
  touch.gap = gap - ball.radius;
  return true;
}

/** The point nearest to x, of triangle t and on from there over edges that bulge: as far as a ball goes until the next
 * answer; `side` as ballFeature()'s. False: x is below it, which nothing is beside the border of a sheet. */
bool nearestAbout(const MeshView& mesh, std::uint32_t t, int side, const Vec3& x, Vec3& point) HD_RT {
  constexpr int kMostSteps = 8;
  constexpr double kHollow = 1e-3;  // Sine: less is a face in parts, and rounding.
  constexpr double kBeside = -0.5;  // Cosine of the way from what is straight below.
  if (mesh.neighbours == nullptr) return false;
  const auto upFrom = [&](std::uint32_t at) HD_RT { return Vec3((side < 0 ? -1 : 1) * faceNormal(mesh, at)); };
  point = nearestOnTriangle(cornersOf(mesh, t), x).point;
  double least = (x - point).squaredNorm();
  for (int i = 0; i < kMostSteps; ++i) {
    const Vec3 up = upFrom(t), on = mesh.vertex(t, 0);
    std::uint32_t next = HD_NO_INDEX;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t across = mesh.neighbours[t][k];
      if (across == HD_NO_INDEX) continue;
      const std::uint32_t opposite = (cornerOf(mesh, across, mesh.triangles[t][k]) + 1) % 3;
      const Vec3 way = mesh.vertex(across, static_cast<int>(opposite)) - on;
      if (up.dot(way) > kHollow * way.norm()) continue;
      const Vec3 there = nearestOnTriangle(cornersOf(mesh, across), x).point;
      if (const double distance = (x - there).squaredNorm(); distance < least) {
        least = distance;
        point = there;
        next = across;
      }
    }
    if (next == HD_NO_INDEX) break;
    t = next;
  }
  const Vec3 way = x - point;
  return upFrom(t).dot(way) > (side == 0 ? 0 : kBeside * way.norm());
}

/** As ballOnPrimitive() from a mesh, near to the triangle of that number (scene_contacts.cc). */
bool ballOnMesh(const BallOfA& ball, std::uint32_t feature, const RoundBody& b, Touch& touch) HD_RT {
  const MeshView* const mesh = b.shape.mesh;
  const std::uint32_t t = (feature - kFirstMeshEdge) / 3;
  if (feature < kFirstMeshEdge || b.shape.kind != ShapeKind::kMesh || mesh == nullptr || t >= mesh->triangle_count)
    return false;
  const Vec3 x = b.X_WO.inverse() * ball.center;
  Vec3 point;
  if (!nearestAbout(*mesh, t, sideOfBall(feature), x, point)) return false;
  const Vec3 way = b.X_WO.q * (x - point);
  const double apart = way.norm();
  if (!(apart > 1e-7) || !sameSide(way, touch.n)) return false;
  touch.n = way / apart;
  touch.gap = apart - ball.radius;
  return true;
}

/** Where one question tells what is nearest to a ball of A. */
bool ballOnSurface(const RoundBody& a, std::uint32_t feature, const BallOfA& ball, const RoundBody& b,
                   Touch& touch) HD_RT {
  if (!isRound(a.shape)) return false;
  if (isEdged(b.shape)) return ballOnPrimitive(ball, b, touch);
  return a.shape.kind == ShapeKind::kSphere && ballOnMesh(ball, feature, b, touch);
}

}  // namespace

Vec3 onAxis(const RoundBody& b, const Vec3& x_W) HD_RT {
  const double half = halfAxis(b.shape);
  return b.X_WO * Vec3(0, 0, std::clamp((b.X_WO.inverse() * x_W).z(), -half, half));
}

NearestResult meetBall(const RoundBody& a, const RoundBody& b, const Vec3& center, NearestQuery& query,
                       BallTouch& out) HD_RT {
  query.x = a.X_WO.inverse() * center;
  Nearest nearest;
  const NearestResult result = nearestOnShape(a.shape, query, nearest);
  if (result != NearestResult::kFound) return result;
  const bool open = a.shape.kind == ShapeKind::kMesh && (a.shape.mesh->flags & HD_MESH_CLOSED) == 0;
  const bool inside = !open && nearest.isInside(query.x);
  const double apart = std::sqrt(nearest.squared_distance);
  const double gap = inside ? -apart : apart;
  const Vec3 toward = apart > 1e-7 ? Vec3((nearest.point - query.x) / gap) : Vec3(-nearest.pseudo_normal);
  out = {a.X_WO * nearest.point, a.X_WO.q * toward, gap - b.shape.size.x()};
  return b.shape.kind != ShapeKind::kCylinder || toDisc(b, center, gap, out) ? result : NearestResult::kNone;
}

void rollTo(const RoundBody& a, std::uint32_t feature, const RoundBody& b, const Vec3& com_W, const Vec3& w_B,
            Touch& touch) HD_RT {
  if (feature == kWayOut) return;
  if (feature >= kFirstEdge && a.shape.kind != ShapeKind::kSphere) {
    if (isAboutAxis(a.shape)) meetMantleAgain(a, feature, b, com_W, w_B, touch);
    return;
  }
  const bool mantle = a.shape.kind == ShapeKind::kCylinder && ToolPoints::isDisc(feature % ToolPoints::kMost);
  if (!isRound(a.shape) && !isRound(b.shape) && !mantle) return;
  if (feature >= kFirstBall && hasMantle(b.shape) && a.shape.kind != ShapeKind::kMesh) {
    meetAgain(a, b, com_W, w_B, touch);
    return;
  }
  const Vec3 before = com_W + touch.r_a;
  BallOfA x{before, 0};
  if (isRound(a.shape)) {
    x = {a.X_WO * Vec3(0, 0, ToolPoints::alongAxis(feature % ToolPoints::kMost, halfAxis(a.shape))), a.shape.size.x()};
  } else if (mantle) {
    x.center = roundAbout(a.shape, a.X_WO, before, touch.n);
  }
  if (isRound(b.shape)) {
    const Vec3 way = x.center - onAxis(b, x.center);
    const double apart = way.norm();
    if (!sameSide(way, touch.n)) return;
    touch.n = way / apart;
    touch.gap = apart - x.radius - b.shape.size.x();
  } else if (!ballOnSurface(a, feature, x, b, touch)) {
    touch.gap += touch.n.dot(x.center - x.radius * touch.n - before);
  }
  touch.r_a = x.center - x.radius * touch.n - com_W;
  touch.moving += w_B.cross(com_W + touch.r_a - before);
}

}  // namespace hapticd
