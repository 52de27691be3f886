/** @file
 * The 6-DOF local model: the contacts that a detector found some ticks ago, tied to the two bodies they were found on,
 * so that every tick sees them where the bodies now are. A plane of B that moves with B meets a point of A that moves
 * with A: exact for flat B, off by the curvature times the square of the slide for others.
 *
 * The hand feels a new model only through the tool's motion, which is continuous; so nothing has to be blended.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/body/response.h"
#include "rt/contact/contact.h"

namespace hapticd {

/** Plain data: it crosses from the collide thread to the servo, and into recordings. */
struct ContactModel {
  struct Point {
    Vec3 p_A = Vec3::Zero();  ///< On A's surface, in A's frame [m].
    Vec3 p_B = Vec3::Zero();  ///< On B's surface, in B's frame [m].
    Vec3 n_B = Vec3::Zero();  ///< From B to A, in B's frame. Unit.
    double area = 0;          ///< [m^2]
    std::uint32_t feature_a = 0, feature_b = 0;
  };

  std::array<Point, kMaxTouches> point;
  std::uint32_t count = 0;
  std::uint32_t body_b = 0;  ///< Whose frame B is; the caller's number.

  /**
   * From what a detector found with the bodies at X_WA and X_WB. Of more than kMaxTouches contacts the deepest stays,
   * and those that lie farthest from all that stay, in place and direction: they hold the tool's rotation. What is
   * apart counts less.
   */
  void build(const ContactSet& found, const Pose& X_WA, const Pose& X_WB) HD_RT;
  /** The touches now; A's centre of mass is at com_W. Returns how many were written. */
  [[nodiscard]] std::uint32_t touches(const Pose& X_WA, const Vec3& com_W, const Pose& X_WB,
                                      std::span<Touch> out) const HD_RT;
};

}  // namespace hapticd
