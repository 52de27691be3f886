/** @file
 * Touching points by parts of body A, and the few contacts that stand for them (thesis section 3.2, eq. 3.1 to 3.3).
 * Servo-safe.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rt/contact/contact.h"
#include "rt/volume/volume_view.h"

namespace hapticd {

inline constexpr std::uint32_t kMaxTouchGroups = 512;

/** What the touching points of one part of A came to. In B's frame, places from its origin. */
struct TouchGroup {
  std::uint32_t part = 0;      ///< Of A, see GroupMap; rising in a list.
  double area = 0;             ///< [m^2]
  double weight = 0;           ///< Sum of (t - d) times area [m^3]: eq. 3.1.
  Vec3 mean = Vec3::Zero();    ///< Weighted place (eq. 3.2), in B [m].
  Vec3 normal = Vec3::Zero();  ///< Weighted sum, out of B; not unit.
  double deepest = 0;          ///< eq. 3.3 [m]
  std::uint32_t face = 0;      ///< Which way the normal looks in A: one of six.
  Wrench integral;             ///< Depth times normal times area, about B's origin [m^3, m^4].
};

/** Which of the six ways along the axes a vector looks most. */
[[nodiscard]] inline std::uint32_t faceOf(const Vec3& n) HD_RT {
  Eigen::Index axis = 0;
  n.cwiseAbs().maxCoeff(&axis);
  return static_cast<std::uint32_t>(axis) * 2 + (n[axis] < 0 ? 1 : 0);
}

/** The parts of A: nodes of one level of its octree, each a run of patches, and what lies above them. */
class GroupMap {
 public:
  /** The deepest level of at most kMaxTouchGroups nodes that is not below the patches'. */
  void build(const VolumeView& volume) HD_RT;
  [[nodiscard]] std::uint32_t count() const HD_RT { return count_; }
  /** Patches of part i: from first(i) to first(i + 1). */
  [[nodiscard]] std::uint32_t first(std::uint32_t i) const HD_RT { return first_[i]; }
  [[nodiscard]] std::uint32_t levels() const HD_RT { return levels_; }
  /** The node `up` levels above part i; its own number for 0. */
  [[nodiscard]] std::uint32_t ancestor(std::uint32_t i, std::uint32_t up) const HD_RT {
    return ancestor_[levels_ - 1 - up][i];
  }

 private:
  std::array<std::uint32_t, kMaxTouchGroups + 1> first_{};
  std::array<std::array<std::uint16_t, kMaxTouchGroups>, HD_OCTREE_MAX_LEVELS> ancestor_{};
  std::uint32_t count_ = 0, levels_ = 0;
};

/**
 * Groups to contacts, at most `most`: by the finest level of A's octree whose cells, split by where they look, are not
 * more; the deepest first if those of the coarsest are. Pose of B as at the query. feature_a tells level, node and
 * face: the same as long as the level is.
 */
void cluster(const GroupMap& map, const std::vector<TouchGroup>& groups, std::uint32_t count, std::uint32_t most,
             const Pose& X_WB, ContactSet& contacts) HD_RT;

struct DetectorQuery;
/**
 * From groups, rising by part, to all that a detector answers but its report: integral, contacts, without those that
 * will have parted, where on B they are. Ages are not touched.
 */
void answer(const DetectorQuery& query, const GroupMap& map, std::vector<TouchGroup>& groups, std::uint32_t count,
            ContactSet& contacts) HD_RT;

/** Gives contacts the age of last time's with the same feature_a, plus one; then these are last time's. */
class ContactAges {
 public:
  void follow(ContactSet& contacts) HD_RT;
  void clear() HD_RT { count_ = 0; }

 private:
  std::array<std::uint32_t, kMostClusters> feature_{}, age_{};
  std::uint32_t count_ = 0;
};

}  // namespace hapticd
