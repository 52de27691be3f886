/** @file
 * Sixteen surface points at once against a distance field, and sixteen spheres against one, in single precision.
 *
 * There are several implementations, chosen once for the processor. All are one text (point_kernel_body.h) over sixteen
 * lanes, without fused operations, so they give the same bits. A point's lane is its number modulo 16, whatever range
 * is asked for, so that sums do not depend on how ranges are cut. This header is included by files compiled for wider
 * instructions: it must stay free of inline code, for the linker might take it from there for everyone.
 *
 * Lengths are in voxels of the field, places in its lattice.
 */
#pragma once

#include <cstdint>

namespace hapticd {

/** A distance field as proto/volume.h stores it. */
struct FieldTable {
  const std::uint32_t* cell;
  const std::int16_t* coarse;
  const std::int16_t* bricks;
  std::uint32_t cells[3];
  float top[3];       ///< The largest place that lies in a cell.
  float fine_step;    ///< Of the values [voxel].
  float coarse_step;  ///< [voxel]
};

/** Points of the other body; readable up to the next multiple of 16. */
struct PointTable {
  const float* x;
  const float* y;
  const float* z;
  const std::uint16_t* area;
};

/** From the points' frame to the lattice: rows of the matrix, then the shift. */
struct Placement {
  float row[3][3];
  float shift[3];
};

/** Bounding balls of patches, sixteen at a time; filled up to a multiple. */
struct PatchTable {
  const float* x;
  const float* y;
  const float* z;
  const float* radius;  ///< [voxel]
};

/** What a range of points came to; to be cleared by the caller, added to by each run. */
struct PointSums {
  enum : int {
    kArea = 0,     ///< Of what is inside, in the points' area steps. All sums below carry this factor.
    kForce = 1,    ///< Depth times gradient, x, y, z.
    kTorque = 4,   ///< The same about the middle.
    kWeight = 7,   ///< Margin less distance, of what is nearer than the margin.
    kMean = 8,     ///< Weighted place from the middle.
    kNormal = 11,  ///< Weighted gradient; not written without a margin: then it is kForce.
    kCount = 14
  };
  alignas(64) float sum[kCount][16];
  alignas(64) float deepest[16];  ///< Of -distance; begin far below 0.
  std::uint32_t touching;         ///< Points nearer than the margin.
};

/** Centres of cells that a surface goes through, all as large; readable and writable up to the next multiple of 16. */
struct PlaceTable {
  float* x;
  float* y;
  float* z;
  std::uint16_t* share;  ///< Written.
  float voxel;           ///< Of the field, in the unit of the places.
  float side;            ///< Of the cells [voxel].
};
inline constexpr float kShareSteps = 4096;               ///< In `share`, of a cell's face.
inline constexpr float kMeanShare = kShareSteps / 1.5F;  ///< Over all directions.

/** Spheres all as large, by their centres: up to 64, readable up to the next multiple of 16. */
struct BallTable {
  const float* x;
  const float* y;
  const float* z;
  float reach;   ///< The sum of their radius and another's.
  float follow;  ///< 1: the place of a pair is the ball's; 0: the other's.
};

/** Spheres; readable up to the next multiple of 16. */
struct SphereTable {
  const float* x;
  const float* y;
  const float* z;
  const float* r;
};

/**
 * Which voxels about a place hold surface: bit x of row[y + kWindow z]. Centres of other voxels in the window's unit, a
 * voxel, from its corner; at least 2 from its sides; readable up to the next multiple of 16.
 */
inline constexpr std::uint32_t kWindow = 32;
struct VoxelWindow {
  const std::uint32_t* row;
  const float* x;
  const float* y;
  const float* z;
  float reach;  ///< Of centres that meet: below 2.
};

/** Of spheres that meet: overlap, and overlap times place; to be cleared by the caller. */
struct BallSums {
  alignas(64) float sum[4][16];
};

/** Of voxels that meet: overlap times the place of those that are not in the window; to be cleared by the caller. */
struct WindowSums {
  BallSums balls;
  std::uint32_t pairs;
  std::uint32_t voxels;  ///< That are in a pair, outside the window.
};

/** One range of points. */
struct PointRange {
  std::uint32_t first, count;
  float middle[3];  ///< Place from which torque and mean are taken.
  float weight;     ///< Factor of the areas: how many points each stands for.
  float margin;     ///< Of touching, not negative [voxel].
};

/** What a vector unit does. Servo-safe. */
struct PointKernel {
  /** Adds a range's points to `sums`; the least distance among them, 0 when one lies deep inside [voxel]. */
  float (*run)(const FieldTable&, const PointTable&, const Placement&, const PointRange&, PointSums& sums) noexcept;
  /** Adds up the lanes: kCount sums and the deepest. */
  void (*reduce)(const PointSums& sums, float* out) noexcept;
  /** Of 16 patches from `first` on: no point of patch i interpolates to less than bound[i] [voxel]. */
  void (*bound)(const FieldTable&, const PatchTable&, const Placement&, std::uint32_t first, float* bound) noexcept;
  /**
   * Takes what 16 patches have moved, shift + turn * lever each, from how far they may; never too little for rounding.
   * Bit i: nothing is left of patch i.
   */
  std::uint32_t (*expire)(float* clearance, const float* lever, float shift, float turn) noexcept;
  /**
   * Moves places, `placement` of which is their lattice's, onto the field's surface along its slope; `share` is the
   * area that each then stands for. A plane with normal n goes through as many cells for each face's area as the sum of
   * n's components. Without a brick, or a slope, a place stays where it is and stands for the mean.
   */
  void (*settle)(const FieldTable&, const Placement&, const PlaceTable&, std::uint32_t count) noexcept;
  /**
   * Of the spheres in `mask` that stand at `from` plus their centres, those that meet one at 0: their bits. `sums`, if
   * there are, get how far each overlaps, and that times the place `at` plus `follow` times its centre.
   */
  std::uint64_t (*meet)(const BallTable&, const float (&from)[3], const float (&at)[3], std::uint64_t mask,
                        BallSums* sums) noexcept;
  void (*reduceBalls)(const BallSums& sums, float* out) noexcept;
  /** Bit i: sphere i of up to 64 meets this one. */
  std::uint64_t (*near)(const SphereTable&, std::uint32_t count, const float (&centre)[3], float radius) noexcept;
  /** Tries each of the other voxels against the 4^3 voxels of the window about it; `first_only`: up to one pair. */
  void (*meetWindow)(const VoxelWindow&, std::uint32_t count, bool first_only, WindowSums& sums) noexcept;
};

extern const PointKernel kPortablePointKernel;
extern const PointKernel kAvx2PointKernel;    ///< Only on x86-64.
extern const PointKernel kAvx512PointKernel;  ///< Only on x86-64.

enum class PointPath : std::uint8_t { kPortable, kAvx2, kAvx512 };

/** The best the processor has, unless chosen otherwise. Servo-safe. */
[[nodiscard]] const PointKernel& pointKernel() noexcept;
[[nodiscard]] PointPath pointPath() noexcept;
/** For tests and benchmarks, before threads start. False: the processor cannot. */
bool choosePointPath(PointPath path) noexcept;
[[nodiscard]] const char* nameOf(PointPath path) noexcept;

}  // namespace hapticd
