/** @file
 * The nearest point of a mesh by the daemon's own tree: as exact as NearestPoint, and fast on a million triangles.
 */
#pragma once

#include "daemon/ipc/snapshot_memory.h"
#include "tools/haptic-bench/model/nearest.h"

namespace haptic_bench {

/** A mesh ready to be asked. */
class TreeNearest {
 public:
  /** Throws Failure when the builder refuses the mesh. */
  explicit TreeNearest(const Model& model);

  /** As NearestPoint::find(). */
  [[nodiscard]] SurfacePoint find(const Vec3& x) const;

 private:
  hapticd::SnapshotMemory mesh_;
};

}  // namespace haptic_bench
