/** @file
 * What a volume is made of: a distance at every lattice point and the triangles of its surface.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "daemon/builder/mesh/mesh.h"
#include "proto/volume.h"
#include "rt/base/math.h"

namespace hapticd {

/** A cell or lattice point by its numbers. */
using Lattice3 = std::array<std::int32_t, 3>;

/** The lattice of a volume (proto/volume.h), in its object's frame. */
struct VolumeLattice {
  double voxel = 0;  ///< Side [m].
  Vec3 origin = Vec3::Zero();
  std::array<std::uint32_t, 3> cells{};  ///< Brick cells along each axis.

  [[nodiscard]] Vec3 at(const Lattice3& p) const { return origin + voxel * Vec3(p[0], p[1], p[2]); }
  [[nodiscard]] std::size_t cellCount() const { return std::size_t{cells[0]} * cells[1] * cells[2]; }
};

/** The signed distance to a closed surface, negative inside [m]. */
class DistanceField {
 public:
  virtual ~DistanceField() = default;
  /** At a lattice point, exact anywhere. */
  [[nodiscard]] virtual float at(const Lattice3& point) = 0;
  /** At the 9^3 lattice points of the brick cell that begins at lattice point `first`, x fastest. */
  virtual void fill(const Lattice3& first, std::span<float, HD_BRICK_VALUES> out);
};

/** How the octree splits. */
enum class OctreeShape : std::uint8_t {
  kEight,       ///< 8-way all the way down.
  kSixtyFour,   ///< 64-way; the root takes what is left over.
  kFiveTwelve,  ///< 512-way, the same.
  kMixed        ///< 8-way, but 64-way over the voxels: fewest bytes a leaf.
};

struct VolumeOptions {
  double margin_voxels = 2;         ///< Of the lattice about the mesh's box.
  double band_voxels = 1;           ///< Bricks where the surface is nearer to the brick cell than this; 0 to 16.
  double point_spacing_m = 0;       ///< Side of the cells of which each gets one point of each side; 0: a voxel.
  std::uint32_t patch_points = 48;  ///< Patches are of the octree level whose mean is nearest to this.
  OctreeShape octree = OctreeShape::kMixed;
  bool sensation = false;   ///< Support areas and phi of each node.
  bool fill_holes = false;  ///< Of an open mesh, see hole_fill.h; else it is refused.
};

struct VolumeSource {
  VolumeLattice lattice;
  DistanceField* field = nullptr;
  std::span<const Float3> vertices;  ///< Of the same surface, closed and outward.
  std::span<const Index3> triangles;
  VolumeOptions options;
};

/** A lattice about a box with a margin and whole brick cells, the box in their middle. */
[[nodiscard]] VolumeLattice latticeAbout(const Vec3& lower, const Vec3& upper, double voxel, double margin_voxels = 2);

}  // namespace hapticd
