#include "daemon/builder/mesh/near_table.h"

#include <bit>
#include <cmath>

namespace hapticd {

NearTable::NearTable(std::size_t most_vertices, float distance_m)
    : distance_(distance_m), first_(std::bit_ceil(most_vertices * 2), HD_NO_INDEX) {}

NearTable::Cell NearTable::cellOf(const Float3& p) const {
  const auto number = [&](float x) { return static_cast<std::int64_t>(std::floor(x / distance_)); };
  return {number(p[0]), number(p[1]), number(p[2])};
}

std::size_t NearTable::slotOf(const Cell& cell, const std::vector<Float3>& kept) const {
  std::uint64_t h = 0;
  for (const std::int64_t x : cell)
    h = (h ^ static_cast<std::uint64_t>(x)) * UINT64_C(0x9e3779b97f4a7c15), h ^= h >> 29;
  const std::size_t mask = first_.size() - 1;
  std::size_t slot = h & mask;
  while (first_[slot] != HD_NO_INDEX && cellOf(kept[first_[slot]]) != cell) slot = (slot + 1) & mask;
  return slot;
}

std::uint32_t NearTable::findOrAdd(const Float3& p, std::vector<Float3>& kept) {
  const Cell here = cellOf(p);
  std::uint32_t nearest = HD_NO_INDEX;
  double nearest2 = distance_ * distance_;
  for (int n = 0; n < 27; ++n) {
    const Cell cell{here[0] + n % 3 - 1, here[1] + n / 3 % 3 - 1, here[2] + n / 9 - 1};
    for (std::uint32_t v = first_[slotOf(cell, kept)]; v != HD_NO_INDEX; v = next_[v]) {
      double d2 = 0;
      for (std::size_t k = 0; k < 3; ++k) d2 += (double{p[k]} - kept[v][k]) * (double{p[k]} - kept[v][k]);
      if (d2 < nearest2 || (d2 == nearest2 && v < nearest)) nearest = v, nearest2 = d2;
    }
  }
  if (nearest != HD_NO_INDEX) return nearest;
  const std::size_t slot = slotOf(here, kept);
  const auto added = static_cast<std::uint32_t>(kept.size());
  kept.push_back({p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f});
  next_.push_back(first_[slot]);
  first_[slot] = added;
  return added;
}

}  // namespace hapticd
