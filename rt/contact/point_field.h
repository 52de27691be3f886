/** @file
 * Detector (b): the surface points of A against the distance field of B.
 *
 * A's patches are culled by their balls against B's field; of those that may touch, sixteen points at a time are looked
 * up in it (point_kernel.h). The force on A of a point is area * depth * gradient of the distance, the derivative of
 * the energy area * depth^2 / 2 of the field as interpolated: so a stiffness times the integral is conservative. Where
 * B has no bricks its coarse field tells depth and direction, however deep.
 *
 * A unit of work is sixteen points or sixteen patches. With too few, every patch gives its first points, which are
 * spread evenly, each standing for more; with fewer than patches, some of each group of patches stand for all of it;
 * with fewer than groups, those that may be deepest are looked at.
 *
 * Coherence: each patch knows how far it may move before any of its points could touch. What moves is bounded by the
 * change of the relative pose, so a fast move uses it up at once. The sums do not depend on it, to the bit.
 *
 * Thin walls: when A has moved by more than a voxel of B since the pose before, the way is looked at in steps of a
 * voxel, 16 at most; what was touched on the way and no longer is, or now from the other side, is a contact whose depth
 * is how far the point went past the face it entered by.
 *
 * Margins up to one voxel or B's band, whichever is less.
 */
#pragma once

#include <vector>

#include "rt/contact/detector.h"
#include "rt/contact/point_kernel.h"
#include "rt/contact/touch_group.h"

namespace hapticd {

/** What sets it apart from the plain one; for measurements and tests. */
struct PointFieldOptions {
  bool coherent = true;  ///< Uses what it learnt from the last query.
  bool swept = true;     ///< Guards thin walls.
};

class PointFieldDetector final : public Detector {
 public:
  /** For tools of up to `max_patches` patches; 28 bytes each. Larger ones are not looked at and reported dropped. */
  explicit PointFieldDetector(std::uint32_t max_patches, const PointFieldOptions& options = {});

  [[nodiscard]] const char* name() const noexcept override { return "point field"; }
  void find(const DetectorQuery& query, ContactSet& contacts) HD_RT override;
  void reset() HD_RT override;

 private:
  struct Run;  // One query.

  void readPatches(const VolumeView& a) HD_RT;
  void scaleRadii(const VolumeView& a, float voxel) HD_RT;
  void survey(Run& run, float shift, float turn) HD_RT;
  void share(Run& run) HD_RT;
  void pick(Run& run, std::uint32_t left) HD_RT;
  void press(Run& run) HD_RT;
  void pressGroup(Run& run, std::uint32_t group) HD_RT;
  void sweep(Run& run) HD_RT;
  void sum(const Run& run, ContactSet& contacts) HD_RT;

  PointFieldOptions options_;
  std::uint32_t max_patches_;
  std::uint64_t a_ = 0, b_ = 0;  ///< VolumeView::number of the last query's.
  float voxel_ = 0;              ///< Of B, in which radius_ is.
  double margin_ = 0;
  bool known_ = false;  ///< clearance_ is of X_BA_.
  Pose X_BA_;
  Vec3 middle_A_ = Vec3::Zero();  ///< From which levers are taken.
  double reach_ = 0;              ///< The longest lever [m].
  std::uint32_t last_group_ = 0;  ///< That touched first.

  // One entry a patch, filled up to sixteen.
  std::vector<float> x_, y_, z_, radius_, lever_, clearance_;
  std::vector<std::uint32_t> take_;  ///< Blocks to look at; 0: none.
  GroupMap map_;
  std::vector<TouchGroup> groups_;   ///< Of this query.
  std::vector<TouchGroup> entries_;  ///< Touched on the way.
  std::vector<std::uint32_t> order_;
  std::vector<float> urgency_;  ///< Of each group: the least clearance.
  ContactAges ages_;
};

}  // namespace hapticd
