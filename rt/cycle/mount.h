/** @file
 * Where a device stands in the world, and how large: what it reads is brought there, and what it is to be sent is
 * brought back.
 *
 * The scene, and all that clients say and see, is of the world W; encoders, velocity estimate and guard are of the
 * device D. So a mount moves what is felt and leaves alone what bounds it. The identity takes no part: not a bit of any
 * number is another.
 *
 * A metre of the hand is s metres of the world: x_W = s R x_D + p. A newton is a newton in both. So the world's lengths
 * and speeds, work, power and torques are s times those of the hand; what is passive in the world is passive in the
 * hand, and a stiffness or a damping of the world is felt s times.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/device.h"

namespace hapticd {

/** Servo thread. Plain data. */
class Mount {
 public:
  static constexpr double kFarthest = 100;                ///< By axis [m]. An object's place may be as far.
  static constexpr double kLeast = 0.01, kLargest = 100;  ///< Scales.

  Mount() noexcept = default;
  /** Of an order that is valid(). */
  explicit Mount(const SetMount& order) noexcept
      : Mount(Pose{vec3(order.p), quat(order.q)}, order.scale != 0 ? order.scale : 1.0) {}
  /** Of a place and a scale that such an order can say. */
  explicit Mount(const Pose& X_WD, double scale = 1) noexcept : X_WD_(X_WD), scale_(scale) {
    Quat& q = X_WD_.q;
    // A unit quaternion stays as it is, so that a mount made from a mount's own order is the same bit for bit.
    if (std::abs(q.squaredNorm() - 1) > 0x1p-49) q.normalize();
    if (q.vec().isZero(0)) q.setIdentity();
    identity_ = X_WD_.p.isZero(0) && q.vec().isZero(0) && scale_ == 1;
    R_WD_ = q.toRotationMatrix();
  }
  /** That gives this mount again. */
  [[nodiscard]] SetMount order(std::uint32_t device) const HD_RT {
    SetMount order{device, 0, {}, {}, scale_};
    store(X_WD_.p, order.p);
    store(X_WD_.q, order.q);
    return order;
  }
  [[nodiscard]] static bool validScale(double s) HD_RT { return s >= kLeast && s <= kLargest; }  // False for NaN.
  /** Finite, not too far, a quaternion that is near a unit one, and a scale or none. */
  [[nodiscard]] static bool valid(const SetMount& order) HD_RT {
    const Vec3 p = vec3(order.p);
    const double norm = quat(order.q).squaredNorm();
    return isFinite(p) && p.cwiseAbs().maxCoeff() <= kFarthest && norm > 0.9 && norm < 1.1 &&  // False for NaN.
           (order.scale == 0 || validScale(order.scale));
  }

  [[nodiscard]] bool identity() const HD_RT { return identity_; }
  [[nodiscard]] const Pose& pose() const HD_RT { return X_WD_; }  ///< X_WD

  [[nodiscard]] double scale() const HD_RT { return scale_; }  ///< Metres of the world for one of the hand.

  /** A direction or a force. */
  [[nodiscard]] Vec3 toWorld(const Vec3& x_D) const HD_RT { return identity_ ? x_D : Vec3(R_WD_ * x_D); }
  [[nodiscard]] Vec3 toDevice(const Vec3& x_W) const HD_RT { return identity_ ? x_W : Vec3(R_WD_.transpose() * x_W); }
  [[nodiscard]] Twist toWorld(const Twist& V) const HD_RT { return {scale_ * toWorld(V.v), toWorld(V.w)}; }
  [[nodiscard]] Wrench toWorld(const Wrench& f) const HD_RT { return {toWorld(f.force), scale_ * toWorld(f.torque)}; }
  [[nodiscard]] Wrench toDevice(const Wrench& f) const HD_RT {
    return {toDevice(f.force), toDevice(f.torque) / scale_};
  }
  /** A device point. */
  [[nodiscard]] Pose toWorld(const Pose& X_D) const HD_RT {
    return identity_ ? X_D : X_WD_ * Pose{scale_ * X_D.p, X_D.q};
  }
  [[nodiscard]] Pose toDevice(const Pose& X_W) const HD_RT {
    if (identity_) return X_W;
    const Pose X = X_WD_.inverse() * X_W;
    return {X.p / scale_, X.q};
  }
  /**
   * Power by axis, where the force and the velocity that made it are not known: by the squares of the axes' parts, so
   * that the sum is that of the world, scaled, and what had no part along a new axis gets none.
   */
  [[nodiscard]] Vec3 powerToDevice(const Vec3& power_W) const HD_RT {
    return identity_ ? power_W : Vec3(R_WD_.cwiseAbs2().transpose() * power_W / scale_);
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
  double scale_ = 1;
  bool identity_ = true;
};

}  // namespace hapticd
