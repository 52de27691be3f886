#include "daemon/builder/volume/octree_builder.h"

#include <algorithm>

namespace hapticd {

std::vector<std::uint32_t> splitsOf(OctreeShape shape, std::uint32_t side_log2) {
  std::vector<std::uint32_t> splits;
  std::uint32_t left = side_log2;
  if (shape == OctreeShape::kMixed && left > 2) {
    splits.push_back(2);
    left -= 2;
  }
  const std::uint32_t each = shape == OctreeShape::kSixtyFour ? 2 : shape == OctreeShape::kFiveTwelve ? 3 : 1;
  for (; left > 0; left -= std::min(left, each)) splits.push_back(std::min(left, each));
  std::reverse(splits.begin(), splits.end());
  return splits;
}

OctreeKeys::OctreeKeys(std::vector<std::uint32_t> splits) : splits_(std::move(splits)), shift_(splits_.size() + 1, 0) {
  for (std::size_t l = splits_.size(); l-- > 0;) shift_[l] = shift_[l + 1] + 3 * splits_[l];
}

std::uint64_t OctreeKeys::keyOf(const Lattice3& voxel) const {
  std::uint64_t key = 0;
  for (std::uint32_t l = 0; l < levels(); ++l) {
    const std::uint32_t down = sideLog2(l + 1), split = splits_[l], last = (1u << split) - 1;
    key <<= 3 * split;
    for (std::size_t k = 0; k < 3; ++k)
      key |= std::uint64_t{static_cast<std::uint32_t>(voxel[k]) >> down & last} << (k * split);
  }
  return key;
}

Lattice3 OctreeKeys::cornerOf(std::uint64_t prefix, std::uint32_t level) const {
  Lattice3 corner{};
  for (std::uint32_t l = level; l-- > 0;) {
    const std::uint32_t split = splits_[l], last = (1u << split) - 1;
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] += static_cast<std::int32_t>((prefix >> (k * split) & last) << sideLog2(l + 1));
    prefix >>= 3 * split;
  }
  return corner;
}

std::vector<BuiltLevel> buildOctree(const OctreeKeys& keys, const std::vector<std::uint64_t>& voxels,
                                    const std::function<bool(const Lattice3&, std::int32_t)>& isSolid) {
  std::vector<BuiltLevel> levels(keys.levels());
  const std::vector<std::uint64_t>* below = &voxels;
  for (std::uint32_t l = keys.levels(); l-- > 0;) {
    BuiltLevel& level = levels[l];
    const std::uint32_t bits = 3 * keys.split(l);
    const std::size_t places = std::size_t{1} << bits, bytes = places / 8;
    const auto side = static_cast<std::int32_t>(1u << keys.sideLog2(l + 1));
    for (std::size_t begin = 0, end; begin < below->size(); begin = end) {
      const std::uint64_t prefix = (*below)[begin] >> bits;
      level.prefix.push_back(prefix);
      if (l + 1 < keys.levels()) level.first.push_back(static_cast<std::uint32_t>(begin));
      const std::size_t base = level.surface.size();
      level.surface.resize(base + bytes, 0);
      for (end = begin; end < below->size() && (*below)[end] >> bits == prefix; ++end) {
        const std::uint64_t place = (*below)[end] & (places - 1);
        level.surface[base + place / 8] |= static_cast<std::uint8_t>(1u << place % 8);
      }
      for (std::uint64_t place = 0; place < places; ++place) {
        const auto bit = static_cast<std::uint8_t>(1u << place % 8);
        if (place % 8 == 0) level.occupied.push_back(level.surface[base + place / 8]);
        if ((level.surface[base + place / 8] & bit) == 0 && isSolid(keys.cornerOf(prefix << bits | place, l + 1), side))
          level.occupied.back() |= bit;
      }
    }
    below = &level.prefix;
  }
  return levels;
}

}  // namespace hapticd
