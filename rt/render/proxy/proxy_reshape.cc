// A solid that gets another shape under the hand that presses it: finer triangles, a dent, a little more than there
// was.
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kFacesHand = 0.5;  // Cosine: the new surface holds the hand back as the old one did.

}  // namespace

/** Whether the solid that holds the proxy has got another shape, and has not jumped. */
bool ProxyRenderer::isReshaped(const Step& step) const HD_RT {
  if (object_ == 0 || step.scene->arrivals() == arrivals_) return false;
  const SceneObject* const object = step.scene->find(object_);
  return object != nullptr && object->shape.number != shape_ && object->shape.kind != ShapeKind::kGroup &&
         (object->flags & HD_OBJECT_ENABLED) != 0 && step.scene->arrivedIn(objectSlot(object_)) != step.scene->tick();
}

/**
 * Puts the proxy on the new surface, where that has come about it by less than the hand has pressed: a facet's breadth
 * of another tessellation would let the hand go. The force grows to twice what it was at most. Deeper in, what has
 * appeared about the hand is not felt until it has been left, as ever.
 */
void ProxyRenderer::followShape(Step& step) HD_RT {
  const std::uint32_t slot = objectSlot(object_);
  const SceneObject& object = step.scene->slot(slot);
  if ((object.flags & HD_OBJECT_TWO_SIDED) != 0) return;
  const Vec3 &x = start_[slot], press = x - step.hipIn(slot);
  const double most = press.norm(), skin = step.skin(object);
  Nearest near;
  if (nearestWithin(object, x, std::max(most, radius_), nullptr, step.work, near) != NearestResult::kFound) return;
  const double distance = std::sqrt(near.squared_distance);
  const bool inside = near.isInside(x);
  if (!inside && distance >= radius_) return;
  const Vec3 n = inside || distance <= skin ? near.pseudo_normal : Vec3((x - near.point) / distance);
  if (!(n.dot(press) >= kFacesHand * most)) return;
  const Vec3 out = near.point + (radius_ + skin) * n;
  if (!((out - x).norm() <= most)) return;
  start_[slot] = out;
  step.carried = true;
}

}  // namespace hapticd
