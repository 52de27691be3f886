// What was put deep into something is told one way out of it: its points there lean nowhere, or each another way.
#include <algorithm>

#include "rt/collide/feature.h"
#include "rt/collide/overlap.h"
#include "rt/collide/purse.h"

namespace hapticd {
namespace {

constexpr double kLittleWay = 2 * kWithin;  ///< What reaches less far into the other is told well by its points [m].

bool isSolid(const Shape& shape) HD_RT {
  if (shape.kind != ShapeKind::kMesh) return shape.kind != ShapeKind::kPlane && shape.kind != ShapeKind::kGroup;
  return isFirm(shape) && (shape.mesh->flags & HD_MESH_CLOSED) != 0 && shape.mesh->node_count > 0;
}

}  // namespace

/** As the one in the lower slot sees it, so that two that ask agree. */
void SceneContacts::tryWayOut(std::uint32_t k, const CollideRequest::Held& held, Purse& purse) HD_RT {
  const CollideRequest::Obstacle& obstacle = held.obstacle[k];
  if (!isSolid(held.shape) || !isSolid(obstacle.shape)) return;
  const Solid mine{held.shape, held.X_WO}, its{obstacle.shape, obstacle.X_WO};
  const bool first = objectSlot(held.object) < obstacle.slot;
  const Parting parting = first ? leastParting(mine, its) : leastParting(its, mine);
  if (!(parting.way > kLittleWay)) return;
  std::uint32_t work = 0;
  const std::uint32_t limit = purse.empty() ? 0 : purse.left();
  const bool within = limit > 0 && (first ? findWithin(mine, its, limit, work) : findWithin(its, mine, limit, work));
  purse.report.work += work;
  if (!within && work >= limit) cut_ |= 1u << k;  // Then the last answer's is carried over.
  if (!within) return;
  Contact contact;
  contact.n_W = first ? Vec3(-parting.n) : parting.n;
  contact.depth = parting.way;
  // Below its middle: it hardly turns anything.
  contact.p_WA = middleOf(mine) - (first ? parting.first : parting.second) * contact.n_W;
  contact.p_WB = contact.p_WA + contact.depth * contact.n_W;
  contact.feature_a = kWayOut;
  if (isFinite(contact.n_W) && isFinite(contact.p_WA)) keep(contact, held, k);
}

}  // namespace hapticd
