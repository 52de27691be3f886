// Corners, edges and rims of the scene's boxes and cylinders against the mantle of a cylinder or a capsule, which they
// may meet between two of its discs or balls.
#include <cmath>

#include "rt/collide/edge_search.h"
#include "rt/collide/feature.h"
#include "rt/collide/mantle.h"
#include "rt/collide/purse.h"

namespace hapticd {
namespace {

/** The middle of part i of a rim at height z. */
Vec3 rimPart(double radius, double z, std::uint32_t i) HD_RT {
  const double angle = 2 * EIGEN_PI * i / kRimParts;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/** Whether x, on a rim, is of the part about that middle. */
bool isOfPart(const Vec3& x, const Vec3& middle) HD_RT {
  const double most = std::cos(1.01 * EIGEN_PI / kRimParts);
  return x.head<2>().dot(middle.head<2>()) >= most * middle.head<2>().squaredNorm();
}

}  // namespace

bool SceneContacts::meetsMantle(const CollideRequest::Held& held, const CollideRequest::Obstacle& obstacle,
                                std::uint32_t feature, const Vec3& start, double margin, Contact& contact) HD_RT {
  ObstacleEdge edge;
  MantleTouch touch;
  const Pose X_AB = held.X_WO.inverse() * obstacle.X_WO;
  if (!edgeOfFeature(obstacle.shape, feature, edge)) return false;
  if (meetMantle(held.shape, edge, X_AB, start, touch) != MantleMeeting::kMet) return false;
  const bool straight = !edge.isRim() && !edge.isCorner();
  if (touch.gap > margin || (straight && (touch.t <= 0 || touch.t >= 1))) return false;  // At its end: a corner's.
  contact.n_W = held.X_WO.q * touch.n;
  contact.p_WB = held.X_WO * touch.x;
  contact.p_WA = contact.p_WB + touch.gap * contact.n_W;
  contact.depth = -touch.gap;
  contact.feature_a = feature;
  return isFinite(contact.n_W) && isFinite(contact.p_WA);
}

void SceneContacts::tryMantle(std::uint32_t k, const CollideRequest::Held& held, double margin, Purse& purse) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  if (!isAboutAxis(held.shape)) return;
  const Pose X_BW = obstacle.X_WO.inverse();
  const auto tryEdge = [&](std::uint32_t feature, const Vec3& start) HD_RT {
    Contact contact;
    ++purse.report.work;
    if (!meetsMantle(held, obstacle, feature, start, margin, contact)) return;
    const Vec3 x_B = X_BW * contact.p_WB;
    if (!leansOut(obstacle.shape, x_B, X_BW.q * contact.n_W)) return;
    if (obstacle.shape.kind == ShapeKind::kCylinder && !isOfPart(x_B, start)) return;  // Another tells it.
    keep(contact, held, k);
    purse.report.touching += contact.depth >= 0 ? 1 : 0;
  };
  if (obstacle.shape.kind == ShapeKind::kBox) {
    for (std::uint32_t i = 0; i < kBoxCorners; ++i) tryEdge(kFirstBoxCorner + i, Vec3::Zero());
    for (std::uint32_t i = 0; i < kBoxEdges; ++i) tryEdge(kFirstBoxEdge + i, Vec3::Zero());
  } else if (obstacle.shape.kind == ShapeKind::kCylinder) {
    for (std::uint32_t i = 0; i < 2 * kRimParts; ++i) {
      const double end = obstacle.shape.size.y();
      tryEdge(kFirstRim + i, rimPart(obstacle.shape.size.x(), i < kRimParts ? -end : end, i));
    }
  }
}

}  // namespace hapticd
