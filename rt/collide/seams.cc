// Where obstacles lie side by side their edges are hidden: a tool that slides over the seam must not be caught there.
#include <array>

#include "rt/collide/purse.h"
#include "rt/collide/scene_contacts.h"

namespace hapticd {
namespace {

constexpr double kStep = 1e-5;  ///< Out of a touch: what is nearer there than that hides it [m].
constexpr double kFreeOfOther =
    4 * kStep;                    ///< From the other obstacle, where it is looked whether the touch is still one.
constexpr double kTurned = 0.99;  ///< Cosine of normals of which the second is another place's.
constexpr double kSunk = 1e-4;    ///< A tool so deep in an obstacle that yields meets what is behind it, too [m].

}  // namespace

/**
 * Of two obstacles that share a corner of the room each is met along its own face: at the touch the other one is in the
 * way, but clear of it the same normal is met again. Of a floor of tiles the edge between two is in the floor, and
 * clear of one the other is met from above: along whatever its edge was told, there is nothing.
 */
bool SceneContacts::isHidden(const Contact& contact, const CollideRequest::Obstacle& its,
                             const CollideRequest::Obstacle& other, Purse& purse) const HD_RT {
  Vec3 x_W = contact.p_WB + kStep * contact.n_W;
  int side = 0;
  PointTouch at;
  if (lookAt(other, other.X_WO.inverse() * x_W, kStep, purse, side, at) != Looked::kNear) return false;
  if (!(at.gap < kSameWay * kStep)) return false;
  x_W += (kFreeOfOther - at.gap) * (other.X_WO.q * at.out);
  if (lookAt(its, its.X_WO.inverse() * x_W, 2 * kFreeOfOther, purse, side, at) != Looked::kNear) return false;
  return (its.X_WO.q * at.out).dot(contact.n_W) < kTurned;
}

void SceneContacts::dropHidden(const CollideRequest::Held& held, Purse& purse) HD_RT {
  std::uint32_t open = 0;       // Bit k: nothing is inside obstacle k, or its mesh may change meanwhile.
  std::uint32_t yields = cut_;  // Obstacle k does not hide others, or is not known well enough.
  for (std::uint32_t k = 0; k < held.count; ++k) {
    const Shape& shape = held.obstacle[k].shape;
    if (!isFirm(shape) || isSheet(shape)) open |= 1u << k;
  }
  for (std::uint32_t i = 0; i < found_.count; ++i) {
    if (found_.contact[i].depth > kSunk) yields |= 1u << body_of_[i];
  }
  for (std::uint32_t i = found_.count; i-- > 0;) {
    const std::uint32_t k = body_of_[i];
    const CollideRequest::Obstacle& its = held.obstacle[k];
    if ((open >> k & 1) != 0 || (volumeOf(its.shape) != nullptr && volumeOf(held.shape) != nullptr)) continue;
    for (std::uint32_t j = 0; j < held.count; ++j) {
      if (j == k || ((yields | open) >> j & 1) != 0) continue;
      if (purse.empty()) return;
      if (!isHidden(found_.contact[i], its, held.obstacle[j], purse)) continue;
      drop(i);
      break;
    }
  }
}

}  // namespace hapticd
