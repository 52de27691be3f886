#include "daemon/builder/volume/volume_source.h"

#include <algorithm>
#include <cmath>

namespace hapticd {

void DistanceField::fill(const Lattice3& first, std::span<float, HD_BRICK_VALUES> out) {
  constexpr std::int32_t kSide = HD_BRICK_SAMPLES;
  std::size_t i = 0;
  for (std::int32_t z = 0; z < kSide; ++z) {
    for (std::int32_t y = 0; y < kSide; ++y)
      for (std::int32_t x = 0; x < kSide; ++x) out[i++] = at({first[0] + x, first[1] + y, first[2] + z});
  }
}

VolumeLattice latticeAbout(const Vec3& lower, const Vec3& upper, double voxel, double margin_voxels) {
  VolumeLattice lattice;
  lattice.voxel = voxel;
  for (int k = 0; k < 3; ++k) {
    const double voxels = (upper[k] - lower[k]) / voxel + 2 * margin_voxels;
    const double most = 1e6;  // Refused later, with a message.
    lattice.cells[static_cast<std::size_t>(k)] =
        static_cast<std::uint32_t>(std::clamp(std::ceil(voxels / HD_BRICK_EDGE), 1.0, most));
    const double side = voxel * HD_BRICK_EDGE * lattice.cells[static_cast<std::size_t>(k)];
    // As the header stores it, so that samples stand where readers look them up.
    lattice.origin[k] = asFloat((lower[k] + upper[k] - side) / 2);
  }
  lattice.voxel = asFloat(voxel);
  return lattice;
}

}  // namespace hapticd
