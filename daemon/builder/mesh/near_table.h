/** @file
 * Finds the nearest of the vertices kept so far within a welding distance.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "daemon/builder/mesh/mesh.h"

namespace hapticd {

/**
 * A grid of cells as wide as the distance. Kept vertices are farther apart than that, so that a cell holds few of them
 * whatever the mesh, and each search looks at 27 cells.
 */
class NearTable {
 public:
  NearTable(std::size_t most_vertices, float distance_m);

  /** The nearest of `kept` within the distance, the first of equals; else `p` joins `kept`. Its number. */
  std::uint32_t findOrAdd(const Float3& p, std::vector<Float3>& kept);

 private:
  using Cell = std::array<std::int64_t, 3>;
  [[nodiscard]] Cell cellOf(const Float3& p) const;
  /** Where a cell stands among the slots, or may. Open addressing, at most half full. */
  [[nodiscard]] std::size_t slotOf(const Cell& cell, const std::vector<Float3>& kept) const;

  double distance_;
  std::vector<std::uint32_t> first_;  ///< Of each slot's cell: its newest vertex, HD_NO_INDEX if free.
  std::vector<std::uint32_t> next_;   ///< Of each kept vertex: the one before it in its cell.
};

}  // namespace hapticd
