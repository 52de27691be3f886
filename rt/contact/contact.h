/** @file
 * What a collision detector reports: one kind of contact record, whichever detector found it, and at most so many of
 * them that a response can be bounded. Servo-safe.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/math.h"

namespace hapticd {

inline constexpr std::uint32_t kMostClusters = 64;  ///< Contacts of one pair of bodies, after clustering.
/** Of a tool with all that is near: of 64 too many have to go before it is known which of them hold it. */
inline constexpr std::uint32_t kMaxContacts = 192;

/**
 * One contact between bodies A (the tool) and B, in the world frame. n points from B to A: a push along it parts them.
 * A record stands for a cluster of touching points (thesis section 3.2): its place and depth are those of the deepest
 * or of the weighted mean, as the clustering says; area is the whole cluster's.
 */
struct Contact {
  Vec3 p_WA = Vec3::Zero();     ///< On A's surface [m].
  Vec3 p_WB = Vec3::Zero();     ///< On B's surface [m].
  Vec3 n_W = Vec3::Zero();      ///< Unit.
  double depth = 0;             ///< Positive inside, negative: that far apart [m].
  double area = 0;              ///< Of A's surface that it stands for [m^2].
  std::uint32_t feature_a = 0;  ///< Where on A, where on B: the same from tick to tick while the contact rests.
  std::uint32_t feature_b = 0;
  std::uint32_t age = 0;  ///< Queries since it was first seen.
};

/** How far a query got within its budget: whatever it did not reach is said, not hidden. */
struct DetectorReport {
  std::uint32_t work = 0;          ///< Units spent, as the detector counts them.
  std::uint32_t touching = 0;      ///< Points or pairs found touching, before clustering.
  std::uint32_t reused = 0;        ///< Of the work that last query's results made unnecessary.
  std::uint32_t dropped = 0;       ///< Parts of the surface that were not looked at: the budget was spent.
  double dropped_area = 0;         ///< Their area [m^2].
  double coarsest = 0;             ///< Edge of the coarsest cell that a contact was taken from [m].
  bool exhausted = false;          ///< The budget ended the search.
  double distance_lower_bound = 0; /**< Nothing is nearer than this [m]; 0 when touching. */
};

/** The contacts of one pair, or of a tool. */
struct ContactSet {
  std::array<Contact, kMaxContacts> contact;
  std::uint32_t count = 0;
  /**
   * The integral of depth over all touching area, before clustering: force per stiffness and area [m^3], torque about
   * A's origin [m^4], both in the world frame on A. Times a stiffness in N/m^3 this is the penalty wrench.
   */
  Wrench integral;
  double touching_area = 0;  ///< [m^2]
  double deepest = 0;        ///< [m]
  DetectorReport report;

  [[nodiscard]] std::span<const Contact> contacts() const HD_RT { return {contact.data(), count}; }
};

}  // namespace hapticd
