/** @file
 * The 6-DOF local model: the contacts that a detector found some ticks ago, tied to the bodies they were found on, so
 * that every tick sees them where the bodies now are. A plane of B that moves with B meets a point of A that moves with
 * A: exact for flat B, off by the curvature times the square of the slide for others.
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

/** Something that A may touch. */
struct ContactBody {
  std::uint32_t number = 0;  ///< The caller's, below 256.
  Pose X_WB;
};

/** Plain data: it crosses from the collide thread to the servo, and into recordings. */
struct ContactModel {
  /** Least distance at which a contact counts half as far from the others as one that touches [m]. */
  static constexpr double kLeastReach = 10e-6;

  static constexpr std::uint32_t kNoFeature = ~std::uint32_t{0};

  struct Point {
    float p_A[3];       ///< On A's surface, in A's frame [m].
    float n_B[3];       ///< From B to A, in B's frame. Unit.
    float offset;       ///< Of the plane: n_B . p_B [m].
    std::uint32_t key;  ///< Body's number in the high byte; below it A's feature. Never 0.

    [[nodiscard]] std::uint32_t body() const HD_RT { return key >> 24; }
    [[nodiscard]] std::uint32_t feature() const HD_RT { return (key & 0xffffffu) - 1; }
  };

  std::array<Point, kMaxTouches> point{};
  std::uint32_t count = 0;

  /**
   * From what a detector found with the bodies at X_WA and X_WB; `body_of` says for each contact which of the bodies
   * (empty: the first). Of more than kMaxTouches contacts the deepest stays, and those that lie farthest from all that
   * stay, in place and direction: they hold the tool's rotation. What is apart counts less, the less it can have
   * closed before the next answer: no gap closes by more than `reach` until then, nor that of contact i by more than
   * reach_of[i], where that is told [m]. A tool that hardly moves so keeps all that carries it, though much more is
   * near: in a narrow hole whatever was left out would be sunk into, be the deepest of the next answer, and push out
   * another. What this model held before is preferred, so that of many that carry the same ones are kept, with the
   * impulses that the response remembers of them. Contacts of feature `always` stay, whatever stands for them.
   */
  void build(const ContactSet& found, const Pose& X_WA, std::span<const ContactBody> bodies, double reach,
             std::span<const std::uint8_t> body_of = {}, std::span<const double> reach_of = {},
             std::uint32_t always = kNoFeature) HD_RT;
  [[nodiscard]] bool has(std::uint32_t key) const HD_RT;
  /** Point i now, its body at X_WB moving with V_WB (of its origin). A's centre of mass is at com_W. */
  [[nodiscard]] Touch touch(std::uint32_t i, const Pose& X_WA, const Vec3& com_W, const Pose& X_WB,
                            const Twist& V_WB) const HD_RT;
};

}  // namespace hapticd
