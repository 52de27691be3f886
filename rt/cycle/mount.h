/** @file
 * Where a device stands in the world: what it reads is brought there, and what it is to be sent is brought back.
 *
 * The scene, and all that clients say and see, is of the world W; encoders, velocity estimate and guard are of the
 * device D. So a mount moves what is felt and leaves alone what bounds it. The identity takes no part: not a bit of any
 * number is another.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/device.h"

namespace hapticd {

/** Servo thread. Plain data. */
class Mount {
 public:
  static constexpr double kFarthest = 100;  ///< By axis [m]. An object's place may be as far.

  Mount() noexcept = default;
  /** Of an order that is valid(). */
  explicit Mount(const SetMount& order) noexcept : Mount(Pose{vec3(order.p), quat(order.q)}) {}
  /** Of a place that such an order can say. */
  explicit Mount(const Pose& X_WD) noexcept : X_WD_(X_WD) {
    Quat& q = X_WD_.q;
    // Only where it is no unit one yet: the order made of a mount gives the same mount, bit for bit.
    if (std::abs(q.squaredNorm() - 1) > 0x1p-49) q.normalize();
    if (q.vec().isZero(0)) q.setIdentity();
    identity_ = X_WD_.p.isZero(0) && q.vec().isZero(0);
    R_WD_ = q.toRotationMatrix();
  }
  /** That gives this mount again. */
  [[nodiscard]] SetMount order(std::uint32_t device) const HD_RT {
    SetMount order{device, 0, {}, {}};
    store(X_WD_.p, order.p);
    store(X_WD_.q, order.q);
    return order;
  }
  /** Finite, not too far, and a quaternion that is near a unit one. */
  [[nodiscard]] static bool valid(const SetMount& order) HD_RT {
    const Vec3 p = vec3(order.p);
    const double norm = quat(order.q).squaredNorm();
    return isFinite(p) && p.cwiseAbs().maxCoeff() <= kFarthest && norm > 0.9 && norm < 1.1;  // False for NaN.
  }

  [[nodiscard]] bool identity() const HD_RT { return identity_; }
  [[nodiscard]] const Pose& pose() const HD_RT { return X_WD_; }  ///< X_WD

  /** A direction, a velocity, a force or a torque. */
  [[nodiscard]] Vec3 toWorld(const Vec3& x_D) const HD_RT { return identity_ ? x_D : Vec3(R_WD_ * x_D); }
  [[nodiscard]] Vec3 toDevice(const Vec3& x_W) const HD_RT { return identity_ ? x_W : Vec3(R_WD_.transpose() * x_W); }
  [[nodiscard]] Twist toWorld(const Twist& V) const HD_RT { return {toWorld(V.v), toWorld(V.w)}; }
  [[nodiscard]] Wrench toDevice(const Wrench& f) const HD_RT { return {toDevice(f.force), toDevice(f.torque)}; }
  /** A device point. */
  [[nodiscard]] Pose toWorld(const Pose& X_D) const HD_RT { return identity_ ? X_D : X_WD_ * X_D; }
  [[nodiscard]] Pose toDevice(const Pose& X_W) const HD_RT { return identity_ ? X_W : X_WD_.inverse() * X_W; }
  /**
   * Power by axis, where the force and the velocity that made it are not known: by the squares of the axes' parts, so
   * that the sum stays and what had no part along a new axis gets none.
   */
  [[nodiscard]] Vec3 powerToDevice(const Vec3& power_W) const HD_RT {
    return identity_ ? power_W : Vec3(R_WD_.cwiseAbs2().transpose() * power_W);
  }
  /**
   * Of the weight that a driver carries, for it knows nothing of its mount: motors bear weights in proportion to g, so
   * this much of it is right along the device's own vertical, on a slope as upside down. What pulls a tilted arm
   * sideways is not known.
   */
  [[nodiscard]] double upright() const HD_RT { return R_WD_(2, 2); }

 private:
  Pose X_WD_;
  Mat3 R_WD_ = Mat3::Identity();
  bool identity_ = true;
};

}  // namespace hapticd
