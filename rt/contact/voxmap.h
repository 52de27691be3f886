/** @file
 * Detector (c): McNeely, Puterbaugh and Troy 1999, the reference that papers compare with: a shell of points of A
 * against the voxel states of B.
 *
 * A point in a surface voxel touches if it lies behind the tangent plane: through the voxel's centre, square to the
 * point's own normal. Depth is the distance from that plane, at most sqrt(3)/2 of a voxel, force is along the point's
 * inward normal (thesis section 3.3.1). No depth is known in a full voxel: there the plane is sqrt(3)/2 of a voxel
 * away, so that nothing is let through at least. Points count alike: area is theirs all the same, for the comparison. A
 * net stiffness clamped beyond about ten points is the response's business. A unit is sixteen points.
 */
#pragma once

#include <vector>

#include "rt/contact/detector.h"
#include "rt/contact/touch_group.h"

namespace hapticd {

class VoxmapDetector final : public Detector {
 public:
  VoxmapDetector();
  [[nodiscard]] const char* name() const noexcept override { return "voxmap"; }
  /** Margins are not known to it. */
  void find(const DetectorQuery& query, ContactSet& contacts) HD_RT override;
  void reset() HD_RT override { ages_.clear(); }

 private:
  GroupMap map_;
  std::vector<TouchGroup> groups_;
  ContactAges ages_;
};

}  // namespace hapticd
