/** @file
 * A built volume (proto/volume.h) as the collide and servo threads read it: typed pointers into a validated, locked
 * mapping.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/volume.h"
#include "rt/base/error.h"
#include "rt/base/math.h"
#include "rt/volume/octree.h"

namespace hapticd {

/** Does not own the memory: whoever published the view keeps it until its readers have passed. All in frame O. */
struct VolumeView {
  const hd_volume_header* header = nullptr;
  /** No two that were validated have the same: what is learnt of one says nothing of the next at its address. */
  std::uint64_t number = 0;

  // The distance field. Sample (x, y, z) of a brick, each 0 to 8: bricks[HD_BRICK_STRIDE * brick + x + 9 (y + 9 z)].
  float voxel = 0;  ///< Side [m].
  std::array<float, 3> origin{};
  std::array<std::uint32_t, 3> cells{};  ///< Brick cells along each axis.
  const std::uint32_t* cell = nullptr;   ///< Brick of each, HD_NO_INDEX: none.
  const std::int16_t* coarse = nullptr;  ///< At the corners of the brick cells, in coarse_step.
  const std::int16_t* bricks = nullptr;  ///< In fine_step.
  std::uint32_t brick_count = 0;
  float fine_step = 0, coarse_step = 0;  ///< [m]
  float band = 0;                        ///< Surface nearer to a brick cell than this: it has a brick [m].

  // The surface points; readable up to the next multiple of HD_POINT_PADDING.
  std::array<const float*, 3> point{};    ///< x, y, z [m].
  const std::uint32_t* normal = nullptr;  ///< Outward, octahedral.
  const std::uint16_t* area = nullptr;    ///< In area_step.
  float area_step = 0;                    ///< [m^2]
  std::uint32_t point_count = 0;
  std::span<const hd_volume_patch> patches;  ///< Patch i belongs to node i of octree level patch_level.
  std::uint32_t patch_level = 0;

  OctreeView octree;
  hd_volume_mass mass{};

  [[nodiscard]] Vec3 originPoint() const HD_RT { return {origin[0], origin[1], origin[2]}; }
  [[nodiscard]] Vec3 pointAt(std::uint32_t i) const HD_RT { return {point[0][i], point[1][i], point[2][i]}; }
};

/**
 * Checks a whole volume (magic, version, checksum, sections, every index and every number that is walked or computed
 * with) and points into it. Control thread. The bytes must be 64-byte aligned and must not change afterwards (sealed).
 * kBadSnapshot says what and where.
 */
[[nodiscard]] Result<VolumeView> validateVolume(std::span<const std::byte> bytes);

}  // namespace hapticd
