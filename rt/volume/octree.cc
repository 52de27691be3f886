#include "rt/volume/octree.h"

namespace hapticd {

namespace {

/** Which octants of a 64-way mask hold any. */
std::uint8_t octantsOf64(std::uint64_t mask) HD_RT {
  mask |= mask >> 1;
  mask |= mask >> 4;
  mask |= mask >> 16;
  // Bits 0, 2, 8 and 10, and 32 above them.
  const auto four = [](std::uint64_t m) HD_RT {
    const unsigned two = static_cast<unsigned>(m | m >> 1) & 0x303u;
    return (two | two >> 6) & 0xfu;
  };
  return static_cast<std::uint8_t>(four(mask & 0x505u) | four(mask >> 32 & 0x505u) << 4);
}

}  // namespace

std::uint8_t octants(const OctreeLevel& level, std::uint32_t node) HD_RT {
  if (level.split == 1) return static_cast<std::uint8_t>(maskWord(level, OctreeMask::kSurface, node));
  if (level.split == 2) return octantsOf64(maskWord(level, OctreeMask::kSurface, node));
  unsigned mask = 0;
  const std::uint32_t half = level.split - 1u;
  for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
    for (std::uint64_t word = maskWord(level, OctreeMask::kSurface, node, w); word != 0; word &= word - 1) {
      const ChildPlace k = childPlace(level.split, 64 * w + static_cast<std::uint32_t>(std::countr_zero(word)));
      mask |= 1u << ((k.x >> half) + 2 * (k.y >> half) + 4 * (k.z >> half));
    }
  }
  return static_cast<std::uint8_t>(mask);
}

TurnedOffsets::TurnedOffsets(const Mat3& R_WO) HD_RT : R_WO_(R_WO) {
  for (int a = 0; a < 3; ++a) {
    for (int split = 0; split < 4; ++split) {
      const int n = 1 << split;
      for (int k = 0; k < 8; ++k) axis_[a][split][k] = R_WO.col(a) * (k < n ? (k + 0.5) / n - 0.5 : 0.0);
    }
  }
}

namespace {

VoxelState ownState(const OctreeView& octree, std::uint32_t x, std::uint32_t y, std::uint32_t z) HD_RT {
  std::uint32_t node = 0;
  for (std::uint32_t l = 0; l < octree.levels; ++l) {
    const OctreeLevel& level = octree.level[l];
    const std::uint32_t down = level.side_log2 - level.split, last = (1u << level.split) - 1;
    const std::uint32_t place =
        (x >> down & last) + ((y >> down & last) << level.split) + ((z >> down & last) << (2 * level.split));
    const std::uint32_t w = place / 64, bit = place % 64;
    const std::uint64_t surface = maskWord(level, OctreeMask::kSurface, node, w);
    if ((surface >> bit & 1) == 0) {
      const bool occupied = (maskWord(level, OctreeMask::kOccupied, node, w) >> bit & 1) != 0;
      return occupied ? VoxelState::kFull : VoxelState::kEmpty;
    }
    if (level.first == nullptr) break;
    std::uint32_t before = static_cast<std::uint32_t>(std::popcount(surface & ((std::uint64_t{1} << bit) - 1)));
    for (std::uint32_t v = 0; v < w; ++v)
      before += static_cast<std::uint32_t>(std::popcount(maskWord(level, OctreeMask::kSurface, node, v)));
    node = level.first[node] + before;
  }
  return VoxelState::kSurface;
}

}  // namespace

VoxelState voxelState(const OctreeView& octree, std::int32_t i, std::int32_t j, std::int32_t k) HD_RT {
  const std::int64_t side = std::int64_t{1} << octree.side_log2;
  const auto own = [&](std::int64_t x, std::int64_t y, std::int64_t z) HD_RT {
    if (x < 0 || y < 0 || z < 0 || x >= side || y >= side || z >= side) return VoxelState::kEmpty;
    return ownState(octree, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                    static_cast<std::uint32_t>(z));
  };
  const VoxelState here = own(i, j, k);
  if (here != VoxelState::kEmpty) return here;
  for (int n = 0; n < 27; ++n) {
    if (own(std::int64_t{i} + n % 3 - 1, std::int64_t{j} + n / 3 % 3 - 1, std::int64_t{k} + n / 9 - 1) ==
        VoxelState::kSurface)
      return VoxelState::kProximity;
  }
  return VoxelState::kEmpty;
}

}  // namespace hapticd
