// The mantle of a cylinder as discs, each as deep as where its rim is lowest.
#include <algorithm>
#include <cmath>

#include "rt/collide/edge_search.h"
#include "rt/collide/feature.h"
#include "rt/collide/purse.h"
#include "rt/collide/scene_contacts.h"

namespace hapticd {
namespace {

/** Sine of a tilt under which a cylinder stands on its end and not on its mantle. */
constexpr double kOnMantle = 0.1;
/** Cosine of the angle about a cylinder's axis within which its disc tells more than a point: three points' of its rim.
 */
constexpr double kBeside = 0.95;

constexpr double kWithEdge = 0.99;  ///< Of a disc's way: an edge on which it moves so much lies along the axis.
constexpr double kAsDeep = 0.1;     ///< Of what a disc says how deep it is: its place is at least so deep.
constexpr double kMetEdge = 1e-5;   ///< A disc this near to where it meets an edge stays [m].

}  // namespace

bool SceneContacts::isBesideDisc(std::uint32_t i, const CollideRequest::Held& held) const HD_RT {
  const Contact& contact = found_.contact[i];
  if (contact.feature_a >= points_.count() || ToolPoints::isDisc(contact.feature_a)) return false;
  const Vec3 p = points_.at(contact.feature_a), down = held.X_WO.q.conjugate() * -contact.n_W;
  const double across = down.head<2>().norm(), radius = held.shape.size.x();
  if (!(across > kOnMantle && p.head<2>().dot(down.head<2>()) > kBeside * radius * across)) return false;
  const double apart = ToolPoints::apart(held.shape.size.y());
  for (std::uint32_t j = 0; j < found_.count; ++j) {
    const Contact& disc = found_.contact[j];
    if (body_of_[j] == body_of_[i] && disc.feature_a < 3 * ToolPoints::kMost &&
        ToolPoints::isDisc(disc.feature_a % ToolPoints::kMost) && disc.n_W.dot(contact.n_W) > kSameWay &&
        disc.depth >= contact.depth - ContactModel::kLeastReach &&
        std::abs((held.X_WO.inverse() * disc.p_WA).z() - p.z()) <= apart)
      return true;
  }
  return false;
}

bool SceneContacts::isMetByMantle(std::uint32_t i) const HD_RT {
  const Contact& disc = found_.contact[i];
  if (disc.feature_a >= kFirstBall || !ToolPoints::isDisc(disc.feature_a)) return false;
  for (std::uint32_t j = 0; j < found_.count; ++j) {
    const Contact& met = found_.contact[j];
    if (body_of_[j] == body_of_[i] && isOfMantle(met.feature_a) && met.n_W.dot(disc.n_W) > kSameWay &&
        (met.p_WA - disc.p_WA).norm() < kInset)
      return true;
  }
  return false;
}

void SceneContacts::dropToldTwice(const CollideRequest::Held& held) HD_RT {
  if (held.shape.kind != ShapeKind::kCylinder) return;
  for (std::uint32_t i = found_.count; i-- > 0;) {
    if (isBesideDisc(i, held) || isMetByMantle(i)) drop(i);
  }
}

SceneContacts::Looked SceneContacts::lookFromDisc(std::uint32_t i, const CollideRequest::Held& held,
                                                  const CollideRequest::Obstacle& obstacle, double reach, Purse& purse,
                                                  int& side, Vec3& x_W, PointTouch& out) const HD_RT {
  const Pose X_AB = held.X_WO.inverse() * obstacle.X_WO, X_BA = X_AB.inverse();
  const double half = held.shape.size.y(), apart = ToolPoints::apart(half);
  Vec3 c = points_.at(i);
  Looked looked = lookAt(obstacle, X_BA * c, reach, purse, side, out);
  if (looked != Looked::kNear) return looked;
  const double least = std::max(-half, c.z() - apart), most = std::min(half, c.z() + apart);
  const auto across = [&]() HD_RT { return (X_AB * out.surface).z(); };
  const auto moveTo = [&](double z) HD_RT {
    c.z() = std::clamp(z, least, most);
    looked = lookAt(obstacle, X_BA * c, reach, purse, side, out);
    return looked == Looked::kNear;
  };
  const double first = c.z(), seen = across();
  if (std::clamp(seen, least, most) != first && moveTo(seen)) {
    // On an edge the contact shifts in proportion to the disc: a secant step finds where both meet. Not on a facet.
    const double second = c.z(), slope = (across() - seen) / (second - first);
    const double meet = (seen - slope * first) / (1 - slope);
    if (slope < kWithEdge && std::abs(std::clamp(meet, least, most) - second) > kMetEdge) {
      const PointTouch met = out;
      const int met_side = side;
      if (!moveTo(meet) || out.gap > met.gap) {
        looked = Looked::kNear;
        c.z() = second;
        out = met;
        side = met_side;
      }
    }
  }
  x_W = held.X_WO * c;
  return looked;
}

bool SceneContacts::lowest(std::uint32_t i, const CollideRequest::Held& held, const Vec3& x_W, const Vec3& n_W,
                           Vec3& p_WA) const HD_RT {
  p_WA = x_W - points_.radius() * n_W;
  if (held.shape.kind != ShapeKind::kCylinder || !ToolPoints::isDisc(i)) return true;
  const Vec3 axis = held.X_WO.q * Vec3::UnitZ(), across = n_W - axis.dot(n_W) * axis;
  const double share = across.norm();
  if (!(share > kOnMantle)) return false;
  p_WA = x_W - held.shape.size.x() / share * across;
  return true;
}

bool SceneContacts::isThere(const Contact& contact, const CollideRequest::Held& held,
                            const CollideRequest::Obstacle& obstacle, double reach, int side,
                            Purse& purse) const HD_RT {
  // Of a blade that leans the edge is in the cylinder, nearer to its mantle than to its end, though the place is
  // beside.
  const Vec3 p = held.X_WO.inverse() * contact.p_WB;
  const double deep = held.shape.size.x() - p.head<2>().norm();
  const double from_end = held.shape.size.y() - std::abs(p.z());
  const bool blade = obstacle.shape.kind == ShapeKind::kMesh && deep > 0;
  if (blade && from_end >= deep) return true;
  if (isSheet(obstacle.shape) && deep > from_end + kInset) return false;  // Its border is in the end.
  PointTouch there;
  const Looked looked = lookAt(obstacle, obstacle.X_WO.inverse() * contact.p_WA, reach, purse, side, there);
  const double most = contact.depth > 0 ? -kAsDeep * contact.depth : -contact.depth;
  if (looked != Looked::kNear || !(there.gap <= ContactModel::kLeastReach + most)) return false;
  // A sheet has no inside: what lies behind it but beyond its border does not touch it.
  return !there.border || there.gap >= -ContactModel::kLeastReach;
}

}  // namespace hapticd
