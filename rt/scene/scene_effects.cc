// When effects must look anew at the objects that have them.
#include <algorithm>

#include "rt/scene/scene.h"

namespace hapticd {

/** What the object in that slot does to hands may be another from now on. */
void Scene::noteEffect(std::uint32_t slot) HD_RT {
  if (effects_[slot].kind != static_cast<std::uint32_t>(EffectKind::kNone)) ++effect_changes_;
}

/**
 * A pose is an order, too: what it changes that is not, by half at least, the motion of this tick by the velocity given
 * or told by poses, is no motion of the object to effects, which have nothing to sweep along.
 */
void Scene::notePosed(std::uint32_t slot, const Twist& V_PO, double since) HD_RT {
  const SceneObject& object = objects_[slot];
  const Motion& above = motion_[object.parent];
  Motion& motion = motion_[slot];
  const Pose back{object.X_PO.p - V_PO.v * dt_, rotated(object.X_PO.q, V_PO.w, -dt_)};
  motion.X_WB = (above.posed ? above.X_WB : objects_[object.parent].X_WO_before) * back;
  motion.posed_after = std::max(motion.pose_set ? since : dt_, above.posed ? above.posed_after : dt_);
  if (effects_[slot].kind == static_cast<std::uint32_t>(EffectKind::kNone)) return;
  const Pose& now = object.X_WO;
  const double aside = kLeastPut + 0.5 * (now.p - motion.X_WB.p).norm();
  const double turned = kLeastPutAngle + 0.5 * now.q.angularDistance(motion.X_WB.q);
  if ((motion.X_WB.p - object.X_WO_before.p).norm() <= aside &&
      motion.X_WB.q.angularDistance(object.X_WO_before.q) <= turned)
    return;
  motion.put = advances_;
  put_over_ = std::max(put_over_, std::min(motion.posed_after, kPoseHold));
}

Pose Scene::onItsWayBefore(std::uint32_t i) const HD_RT {
  return motion_[i].put == advances_ ? motion_[i].X_WB : objects_[i].X_WO_before;
}

}  // namespace hapticd
