#include "daemon/builder/volume/thin_walls.h"

#include <fmt/core.h>

#include "rt/volume/distance.h"
#include "rt/volume/octahedral.h"

namespace hapticd {

std::string noteOfThinWalls(const VolumeView& volume) {
  constexpr double kNoInside = 0.01, kTold = 0.05;  // [voxel]; share.
  const double voxel = double{volume.voxel};
  double thin = 0, all = 0;
  for (std::uint32_t i = 0; i < volume.point_count; ++i) {
    const Vec3 in = -octahedralNormal(volume.normal[i]);
    bool shown = false;
    for (int quarter = 1; quarter <= 4 && !shown; ++quarter)
      shown = distanceAt(volume, volume.pointAt(i) + 0.25 * quarter * voxel * in).value < -kNoInside * voxel;
    all += volume.area[i];
    thin += shown ? 0 : volume.area[i];
  }
  if (!(thin > kTold * all)) return {};
  return fmt::format(
      "{:.0f} % of its surface is of walls so thin that such voxels hold nothing of them: other volumes pass; choose "
      "voxels of half their thickness (--voxel)",
      100 * thin / all);
}

}  // namespace hapticd
