/** @file
 * The distance field of a volume: bricks near the surface, corners everywhere.
 */
#pragma once

#include <vector>

#include "daemon/builder/volume/volume_source.h"

namespace hapticd {

struct BuiltField {
  std::vector<std::uint32_t> cells;  ///< Brick of each cell, HD_NO_INDEX: none. Bricks in Morton order of their cells.
  std::vector<std::int16_t> coarse;  ///< In coarse_step.
  std::vector<std::int16_t> bricks;  ///< In fine_step.
  float fine_step = 0, coarse_step = 0;
  std::uint32_t brick_count = 0;

  /** Whether a lattice point is inside; exact where a sample stands, else by the nearest corner. */
  [[nodiscard]] bool isInside(const VolumeLattice& lattice, const Lattice3& point) const;
};

/** Empty `cells` if the monitor stopped it. `fraction` of progress from `begin` to `end`. */
[[nodiscard]] BuiltField buildField(const VolumeLattice& lattice, DistanceField& field, double band_m,
                                    BuildMonitor& monitor, float begin, float end);

}  // namespace hapticd
