// Where objects are in each tick: by their poses, their velocities, and those of what they hang on.
#include <algorithm>

#include "rt/scene/foreseen.h"
#include "rt/scene/scene.h"

namespace hapticd {
namespace {

constexpr double kLeaseRounding = 1e-7;  ///< Of a lease [s].

bool same(const Pose& a, const Pose& b) HD_RT { return a.p == b.p && a.q.coeffs() == b.q.coeffs(); }

/** Angular velocity that takes `from` to `to` in dt: the shorter way, in the frame both map to. */
Vec3 angularVelocity(const Quat& from, const Quat& to, double dt) HD_RT {
  Quat d = to * from.conjugate();
  if (d.w() < 0) d.coeffs() = -d.coeffs();
  const double s = d.vec().norm();
  if (s == 0) return Vec3::Zero();
  return d.vec() * (2 * std::atan2(s, d.w()) / (s * dt));
}

}  // namespace

void Scene::advance(double dt) HD_RT {
  time_ += dt;
  dt_ = dt;
  ++advances_;
  if (!moves_are_new_) move_count_ = 0;
  moves_are_new_ = false;
  put_over_ = 0;
  if (settled_) return;
  settled_ = true;
  for (std::uint32_t i = 0; i < order_count_; ++i) {
    if (advanceObject(order_[i], dt)) settled_ = false;
  }
}

/** Of a tick's time: what its motion's lease leaves. */
double Scene::lasting(const Motion& motion, double dt) HD_RT {
  return motion.lease > 0 ? std::min(motion.lease, dt) : dt;
}

/**
 * In its parent: where its velocity, given or told by the poses before, brings it; no farther than contacts look.
 * Without a pose, where it comes.
 */
Pose Scene::foreseenIn(const SceneObject& object, const Motion& motion, double dt) const HD_RT {
  const bool driven = !isZero(object.V_PO);
  if (!motion.pose_set && !driven) return object.X_PO;
  if (!motion.pose_set) {
    const double time = lasting(motion, dt);
    return {object.X_PO.p + time * object.V_PO.v, rotated(object.X_PO.q, object.V_PO.w, time)};
  }
  const Twist none, &told = motion.told_for > 0 ? motion.V_told : none;
  const Twist& V = driven ? object.V_PO : told;
  const double time = driven ? std::min(dt, kPoseHold) : std::min(time_ - motion.pose_time, kMetTime);
  return {motion.X_PO_before.p + time * V.v, rotated(motion.X_PO_before.q, V.w, time)};
}

/** True if the object must be looked at next tick as well. */
bool Scene::advanceObject(std::uint32_t slot, double dt) HD_RT {
  SceneObject& object = objects_[slot];
  Motion& motion = motion_[slot];
  const SceneObject& parent = objects_[object.parent];
  const Motion& above = motion_[object.parent];
  const bool driven = !isZero(object.V_PO);
  const bool enabled = (object.flags & HD_OBJECT_ENABLED) != 0, appears = enabled && motion.hidden;
  object.appeared = appears || object.shape.mesh != motion.mesh;
  motion.hidden = !enabled;
  motion.mesh = object.shape.mesh;
  const bool still = !motion.pose_set && !motion.jump && !motion.world_moved && !object.moved && !motion.told;
  if (still && !driven && !above.world_moved && !above.told) {
    motion.teleported = motion.reshaped = motion.posed = false;
    return object.appeared;
  }

  const double since = time_ - motion.pose_time;
  motion.posed = above.posed || motion.pose_set;
  motion.X_WF = (above.posed ? above.X_WF : parent.X_WO) * foreseenIn(object, motion, dt);
  motion.told = above.told || motion.told_for > 0;
  if (motion.pose_set) {
    const double time = std::clamp(since, dt, std::max(dt, kPoseHold));
    const Vec3 step = object.X_PO.p - motion.X_PO_before.p;
    if (motion.reshaped || step.norm() > kTeleportSpeed * time ||
        object.X_PO.q.angularDistance(motion.X_PO_before.q) > kTeleportAngle) {
      motion.jump = true;
    }
    motion.pose_time = time_;
  } else if (driven) {
    const double time = lasting(motion, dt);
    object.X_PO.p += object.V_PO.v * time;
    object.X_PO.q = rotated(object.X_PO.q, object.V_PO.w, time);
  }
  const bool ends = driven && !motion.pose_set && motion.lease > 0 && (motion.lease -= dt) < kLeaseRounding;
  motion.world_moved = motion.jump || above.world_moved || !same(object.X_PO, motion.X_PO_before);
  motion.teleported = motion.jump || above.teleported;

  if (driven || motion.jump) {
    motion.told_for = 0;
  } else if (motion.pose_set && dt > 0) {
    const double time = std::clamp(since, dt, std::max(dt, kPoseSpread));
    motion.V_told.v = (object.X_PO.p - motion.X_PO_before.p) / time;
    motion.V_told.w = angularVelocity(motion.X_PO_before.q, object.X_PO.q, time);
    motion.told_for = isZero(motion.V_told) ? 0 : kLatePose * time;
  } else {
    motion.told_for = std::max(0.0, motion.told_for - dt);
  }
  motion.told = motion.told || motion.told_for > 0 || driven;  // Driven, what is above may have yet to move.
  const Twist V_PO = motion.told_for > 0 ? motion.V_told : object.V_PO;
  object.X_WO_before = object.X_WO;
  const Vec3 middle_O = object.toLocal(object.center_W);
  object.place(parent.X_WO * object.X_PO);
  // Of what has no end, one metre.
  const Step step{object.X_WO_before, object.X_WO, motion.X_WF, middle_O, std::min(object.radius, 1.0)};
  if (motion.teleported || (motion.posed && !isForeseen(step, kUnmetStep))) motion.unmet = time_;
  if (motion.teleported) {
    ++arrivals_;
    motion.arrived = tick_;
    noteEffect(slot);
    object.X_WO_before = object.X_WO;
    motion.X_WB = object.X_WO;
  } else if (motion.posed && effecting_count_ > 0) {
    notePosed(slot, motion.pose_set || driven ? V_PO : Twist{}, since);
  }
  if (appears) object.X_WO_before = object.X_WO;
  const Vec3 arm = object.X_WO.p - parent.X_WO.p;
  object.V_WO.v = parent.V_WO.v + parent.V_WO.w.cross(arm) + parent.X_WO.q * V_PO.v;
  object.V_WO.w = parent.V_WO.w + parent.X_WO.q * V_PO.w;
  object.moved = !same(object.X_WO, object.X_WO_before);
  object.placeBall();
  motion.X_PO_before = object.X_PO;
  motion.pose_set = false;
  motion.jump = false;
  motion.reshaped = false;
  if (ends) halt(object);
  return driven || motion.world_moved || motion.told || object.appeared;
}

}  // namespace hapticd
