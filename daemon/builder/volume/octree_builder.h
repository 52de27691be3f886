/** @file
 * The octree of surface voxels as proto/volume.h stores it.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "daemon/builder/volume/volume_source.h"

namespace hapticd {

/** The splits of the levels from the root down, for a root of 2^side_log2 voxels. */
[[nodiscard]] std::vector<std::uint32_t> splitsOf(OctreeShape shape, std::uint32_t side_log2);

/** The way to a voxel: the place in each level's mask, root first, 3 * split bits each. Sorts as nodes stand. */
class OctreeKeys {
 public:
  explicit OctreeKeys(std::vector<std::uint32_t> splits);
  [[nodiscard]] std::uint64_t keyOf(const Lattice3& voxel) const;
  /** Lower corner voxel of the cube that the first bits of a key name: a node of `level`, or a voxel at levels(). */
  [[nodiscard]] Lattice3 cornerOf(std::uint64_t prefix, std::uint32_t level) const;
  /** The prefix that names the node of `level` on the way to a voxel's key. */
  [[nodiscard]] std::uint64_t prefix(std::uint64_t key, std::uint32_t level) const { return key >> shift_[level]; }
  [[nodiscard]] std::uint32_t levels() const { return static_cast<std::uint32_t>(splits_.size()); }
  [[nodiscard]] std::uint32_t split(std::uint32_t level) const { return splits_[level]; }
  /** log2 of the side of a node of that level in voxels. */
  [[nodiscard]] std::uint32_t sideLog2(std::uint32_t level) const { return shift_[level] / 3; }

 private:
  std::vector<std::uint32_t> splits_;
  std::vector<std::uint32_t> shift_;  ///< Bits of a key below the prefix of each level; one more for the voxels: 0.
};

/** One level's arrays. */
struct BuiltLevel {
  std::vector<std::uint64_t> prefix;  ///< Of each node, rising.
  std::vector<std::uint8_t> occupied, surface;
  std::vector<std::uint32_t> first;  ///< Empty on the last level.
};

/**
 * `voxels`: keys, rising, each once, not empty. `isSolid(corner, side)`: whether the cube of that lower corner and side
 * in voxels, which holds no surface, is inside.
 */
[[nodiscard]] std::vector<BuiltLevel> buildOctree(const OctreeKeys& keys, const std::vector<std::uint64_t>& voxels,
                                                  const std::function<bool(const Lattice3&, std::int32_t)>& isSolid);

}  // namespace hapticd
