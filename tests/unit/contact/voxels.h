/** @file
 * What tests of detectors ask, and a volume's surface voxels one by one.
 */
#pragma once

#include <vector>

#include "rt/contact/detector.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd::test {

inline DetectorQuery queryOf(const TestVolume& a, const TestVolume& b, const Pose& X_WA, const Pose& X_WB = {}) {
  DetectorQuery query;
  query.a.volume = &a.view;
  query.b.volume = &b.view;
  query.a.X_WO = query.a.X_WO_before = X_WA;
  query.b.X_WO = query.b.X_WO_before = X_WB;
  return query;
}

/** Centres of a volume's surface voxels, in the object's frame. */
inline std::vector<Vec3> surfaceVoxels(const VolumeView& v) {
  std::vector<Vec3> out;
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(8 * v.cells[2]); ++k) {
    for (std::int32_t j = 0; j < static_cast<std::int32_t>(8 * v.cells[1]); ++j) {
      for (std::int32_t i = 0; i < static_cast<std::int32_t>(8 * v.cells[0]); ++i) {
        if (voxelState(v.octree, i, j, k) != VoxelState::kSurface) continue;
        out.push_back(v.originPoint() + v.voxel * (Vec3(i, j, k) + Vec3::Constant(0.5)));
      }
    }
  }
  return out;
}

}  // namespace hapticd::test
