/** @file
 * The octree of surface voxels and its implicit spheres (thesis section 3.2.2): only masks are stored, a node's place
 * and size follow from the way to it. Servo-safe.
 *
 * A node's side is 2^L voxels; its bounding ball has the radius s 2^(L-1) sqrt(3). A level may split in 2, 4 or 8 along
 * each axis (8-, 64-, 512-way). On an axis child k of n stands at side * ((k + 1/2) / n - 1/2) from the node's centre.
 */
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "proto/volume.h"
#include "rt/base/math.h"

namespace hapticd {

/** One level: all its nodes split alike. */
struct OctreeLevel {
  const std::uint8_t* occupied = nullptr;  ///< Masks, 8^split bits each, lowest bit first.
  const std::uint8_t* surface = nullptr;
  const std::uint32_t* first = nullptr;  ///< First child on the next level; null on the last.
  std::uint32_t node_count = 0;
  std::uint8_t split = 1;      ///< log2 of the parts along an axis.
  std::uint8_t side_log2 = 0;  ///< Of a node's side in voxels.
};

struct OctreeView {
  std::array<OctreeLevel, HD_OCTREE_MAX_LEVELS> level;
  std::uint32_t levels = 0;
  std::uint32_t side_log2 = 0;
  std::array<std::uint32_t, HD_OCTREE_MAX_LEVELS> first_sensation{};  ///< Of each level, in `sensation`.
  const hd_octree_sensation* sensation = nullptr;                     ///< Null: not built.
};

enum class OctreeMask : std::uint8_t { kOccupied, kSurface };

/** Number of 64-bit words of a mask, and how many bits the first (and for 8-way only) has. */
[[nodiscard]] constexpr std::uint32_t maskWords(std::uint32_t split) HD_RT { return split == 3 ? 8 : 1; }
[[nodiscard]] constexpr std::uint32_t maskBytes(std::uint32_t split) HD_RT { return 1u << (3 * split - 3); }

/** Word `w` of a node's mask; bit b of it is child 64 w + b, which is x + n (y + n z) for a level of n parts. */
[[nodiscard]] inline std::uint64_t maskWord(const OctreeLevel& level, OctreeMask which, std::uint32_t node,
                                            std::uint32_t w = 0) HD_RT {
  const std::uint8_t* masks = which == OctreeMask::kSurface ? level.surface : level.occupied;
  const std::size_t bytes = maskBytes(level.split);
  if (bytes == 1) return masks[node];
  std::uint64_t word;
  std::memcpy(&word, masks + bytes * node + std::size_t{8} * w, sizeof word);
  return word;
}

/** Children that hold surface: 1 to 512. */
[[nodiscard]] inline std::uint32_t childCount(const OctreeLevel& level, std::uint32_t node) HD_RT {
  std::uint32_t count = 0;
  for (std::uint32_t w = 0; w < maskWords(level.split); ++w)
    count += static_cast<std::uint32_t>(std::popcount(maskWord(level, OctreeMask::kSurface, node, w)));
  return count;
}

/** Calls visit(place, child) for each child that holds surface; on the last level `child` is a count from 0. */
template <class Visit>
void forEachChild(const OctreeLevel& level, std::uint32_t node, Visit&& visit) HD_RT {
  std::uint32_t child = level.first != nullptr ? level.first[node] : 0;
  for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
    for (std::uint64_t word = maskWord(level, OctreeMask::kSurface, node, w); word != 0; word &= word - 1)
      visit(64 * w + static_cast<std::uint32_t>(std::countr_zero(word)), child++);
  }
}

/** The node's octants that hold surface: its mask, or what a 64- or 512-way mask comes to. For tightSphere(). */
[[nodiscard]] std::uint8_t octants(const OctreeLevel& level, std::uint32_t node) HD_RT;

/** Where a place of a level stands on each axis, 0 to 2^split - 1. */
struct ChildPlace {
  std::uint32_t x, y, z;
};
[[nodiscard]] constexpr ChildPlace childPlace(std::uint32_t split, std::uint32_t place) HD_RT {
  const std::uint32_t last = (1u << split) - 1;
  return {place & last, place >> split & last, place >> (2 * split) & last};
}

/**
 * The offsets of all children of all splits in the world's directions, turned once per query (thesis section 3.2.3).
 * Offsets are for a node of side 1 and only scaled after that.
 */
class TurnedOffsets {
 public:
  explicit TurnedOffsets(const Mat3& R_WO) HD_RT;

  /** From the node's centre to the child's, for a node of side 1, in W. */
  [[nodiscard]] Vec3 offset(std::uint32_t split, std::uint32_t place) const HD_RT {
    const ChildPlace k = childPlace(split, place);
    return axis_[0][split][k.x] + axis_[1][split][k.y] + axis_[2][split][k.z];
  }
  /** The same for the centre of a tight sphere (rt/volume/tight_sphere.h), given for a node of half-side 1 in O. */
  [[nodiscard]] Vec3 turned(const Vec3& v_O) const HD_RT { return R_WO_ * v_O; }

 private:
  Mat3 R_WO_;
  Vec3 axis_[3][4][8];
};

enum class VoxelState : std::uint8_t { kEmpty, kProximity, kSurface, kFull };

/**
 * What voxel (i, j, k) is. Empty outside the root. Proximity: empty, with a surface voxel among its 26 neighbours
 * (McNeely et al. 1999). One way down the tree, 27 for an empty voxel.
 */
[[nodiscard]] VoxelState voxelState(const OctreeView& octree, std::int32_t i, std::int32_t j, std::int32_t k) HD_RT;

}  // namespace hapticd
