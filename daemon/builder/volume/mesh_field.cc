#include "daemon/builder/volume/mesh_field.h"

#include <cmath>
#include <limits>

#include "rt/geometry/nearest/nearest.h"

namespace hapticd {

float MeshField::within(const Lattice3& point, double reach, double neighbour) const {
  NearestQuery query;
  query.x = lattice_.at(point);
  query.reach = reach;
  query.limit = std::numeric_limits<std::uint32_t>::max();
  Nearest nearest;
  if (nearestOnMesh(mesh_, query, nearest) != NearestResult::kFound) return static_cast<float>(reach);
  const double distance = std::sqrt(nearest.squared_distance);
  bool inside = false;
  if (winding_ == nullptr) {
    inside = nearest.isInside(query.x);
  } else if (std::abs(neighbour) > lattice_.voxel * 1.0001) {
    inside = neighbour < 0;  // No surface stands between the two.
  } else {
    inside = winding_->isInside(query.x);
  }
  return static_cast<float>(inside ? -distance : distance);
}

void MeshField::fill(const Lattice3& first, std::span<float, HD_BRICK_VALUES> out) {
  constexpr std::int32_t kSide = HD_BRICK_SAMPLES;
  std::size_t at = 0;
  for (std::int32_t z = 0; z < kSide; ++z) {
    for (std::int32_t y = 0; y < kSide; ++y) {
      for (std::int32_t x = 0; x < kSide; ++x, ++at) {
        // A neighbour a voxel away is no farther than its distance and a voxel: a short search.
        const std::size_t neighbour = x > 0   ? at - 1
                                      : y > 0 ? at - kSide
                                              : at - static_cast<std::size_t>(kSide) * kSide;
        const double reach = at == 0 ? kAnywhere : (std::abs(out[neighbour]) + lattice_.voxel) * 1.0001 + 1e-9;
        out[at] = within({first[0] + x, first[1] + y, first[2] + z}, reach, at == 0 ? 0 : double{out[neighbour]});
      }
    }
  }
}

}  // namespace hapticd
