/** @file
 * The flat form of a built volume: a solid as distances in bricks, surface points in patches and an octree of surface
 * voxels. One block of offsets and arrays that the builder writes, the daemon validates and the collide thread reads in
 * place. Also the form of the cache on disk.
 *
 * Position independent: sections are byte offsets from its start, 64-byte aligned, in the order of hd_volume_section.
 * Metres, in the object's frame. Distances are negative inside. Lattice point (i, j, k) is at origin + voxel * (i, j,
 * k); voxel (i, j, k) is the cube from lattice point (i, j, k) to (i + 1, j + 1, k + 1); brick cell (I, J, K) is the
 * cube of 8^3 voxels from voxel (8 I, 8 J, 8 K). Everywhere x runs fastest, then y, then z.
 */
#ifndef HAPTICD_PROTO_VOLUME_H
#define HAPTICD_PROTO_VOLUME_H

#include <stdint.h>

#include "proto/snapshot.h"

#define HD_VOLUME_MAGIC UINT64_C(0x314c4f5654504148) /**< "HAPTVOL1" */
#define HD_VOLUME_VERSION 2u

#define HD_BRICK_EDGE 8u     /**< Voxels along a brick. */
#define HD_BRICK_SAMPLES 9u  /**< Distances along it: neighbours share a face, so that no lookup needs two bricks. */
#define HD_BRICK_VALUES 729u /**< 9^3. */
#define HD_BRICK_STRIDE 736u /**< Values from one brick to the next: 23 cache lines. */
#define HD_POINT_PADDING 16u /**< Point arrays are filled up to a multiple: a vector may read past the last one. */
#define HD_OCTREE_MAX_LEVELS 13u
#define HD_OCTREE_MAX_SIDE 13u /**< log2 of the root's side in voxels. */

#define HD_MAX_BRICK_CELLS 67108864u
#define HD_MAX_BRICKS 2000000u /**< So that the number of a sample fits 31 bits: a gather's index. */
#define HD_MAX_POINTS 67108864u
#define HD_MIN_VOXEL 1e-6f /**< Smallest and largest side of a voxel [m]. */
#define HD_MAX_VOXEL 1.0f

/** In hd_mesh_upload.flags: the solid is wanted as a volume too; an hd_volume_request follows the triangles. */
#define HD_UPLOAD_VOLUME (UINT32_C(1) << 2)
/** With it: holes of the surface are closed for the volume, by winding numbers; else an open one is refused. */
#define HD_UPLOAD_FILL_HOLES (UINT32_C(1) << 3)

struct hd_volume_request {
  float voxel_m;         /**< HD_MIN_VOXEL to HD_MAX_VOXEL. */
  float point_spacing_m; /**< Side of the cells that get a surface point each, or 0: a voxel. */
  uint32_t reserved[2];  /**< 0. */
};

enum hd_volume_section {
  HD_VOLUME_CELLS = 0,   /**< uint32 per brick cell: its brick, or HD_NO_INDEX: the surface is not near. */
  HD_VOLUME_COARSE = 1,  /**< int16 per corner of the brick cells, (nx+1)(ny+1)(nz+1): distance / coarse_step. */
  HD_VOLUME_BRICKS = 2,  /**< int16[HD_BRICK_STRIDE] per brick: distance / fine_step at its 9^3 lattice points. */
  HD_VOLUME_POINT_X = 3, /**< float per point, padded; the padding repeats the last point. */
  HD_VOLUME_POINT_Y = 4,
  HD_VOLUME_POINT_Z = 5,
  HD_VOLUME_NORMALS = 6,    /**< uint32 per point, padded: outward normal, octahedral, see rt/volume/octahedral.h. */
  HD_VOLUME_AREAS = 7,      /**< uint16 per point, padded by 0: its share of the surface / area_step. */
  HD_VOLUME_PATCHES = 8,    /**< hd_volume_patch: one per octree node of level patch_level, in the same order. */
  HD_VOLUME_OCCUPIED = 9,   /**< Bit masks of the octree's nodes, level by level: children that hold any solid. */
  HD_VOLUME_SURFACE = 10,   /**< The same: children that hold surface; a part of the occupied ones. */
  HD_VOLUME_FIRST = 11,     /**< uint32 per node of every level but the last: its first child on the next level. */
  HD_VOLUME_SENSATION = 12, /**< hd_octree_sensation per node, level by level; or empty. */
  HD_VOLUME_SECTIONS = 13
};

/**
 * The points of one octree node. Any first part of them is spread evenly over all of them: a coarser patch is a shorter
 * one. May be empty where points are sparser than nodes.
 */
struct hd_volume_patch {
  float center[3]; /**< Of a ball about its points. */
  float radius;
  uint32_t first; /**< Point. Patches follow one another without a gap. */
  uint32_t count;
  float area;   /**< Sum over its points [m^2]. */
  float spread; /**< Greatest distance of a point of the patch from the nearest of its first quarter [m]. */
};

/** What the descent weighs (Otaduy and Lin 2003; thesis eq. 3.5, 3.6). */
struct hd_octree_sensation {
  float support_area; /**< D: the least of its voxels' [m^2]. */
  float empty;        /**< phi: the share of the node's cube that holds neither surface nor solid voxels. */
};

/** The octree's levels from the root (level 0) down. The children of the last are voxels. */
struct hd_octree_level {
  uint32_t split_log2;   /**< 1, 2 or 3: the node has 8, 64 or 512 places for children. */
  uint32_t node_count;   /**< Nodes hold surface; a child without is told by the masks alone. */
  uint64_t mask_offset;  /**< Of its first mask, in bytes, in both mask sections. A mask has 8^split_log2 bits. */
  uint32_t first_offset; /**< Of its first entry in HD_VOLUME_FIRST, in entries. The last level has none. */
  uint32_t reserved;
};

/** The solid, per density of 1 kg/m^3, in the object's frame. */
struct hd_volume_mass {
  double volume;      /**< [m^3] */
  double centroid[3]; /**< [m] */
  double inertia[6];  /**< xx, yy, zz, xy, yz, zx of the inertia tensor about the centroid [m^5]. */
};

struct hd_volume_header {
  uint64_t magic;
  uint32_t version;
  uint32_t flags; /**< 0. */
  uint64_t total_bytes;
  uint64_t checksum; /**< As in snapshot.h, of everything after this header. */
  float voxel;       /**< Side [m]. */
  float origin[3];
  uint32_t cells[3]; /**< Brick cells along x, y, z. */
  uint32_t brick_count;
  float fine_step;   /**< Of the bricks' values [m]. */
  float coarse_step; /**< Of the corners' values [m]. */
  float area_step;   /**< Of the points' areas [m^2]. */
  float band;        /**< Every brick cell that the surface comes nearer than this has a brick [m]. */
  uint32_t point_count;
  uint32_t patch_count;
  uint32_t patch_level;
  uint32_t surface_voxels; /**< Leaves of the octree. */
  uint32_t level_count;
  uint32_t side_log2; /**< Of the root's cube in voxels; its corner is lattice point 0. */
  float lower[3];     /**< Box of the points. */
  float upper[3];
  double area; /**< Of the surface [m^2]. */
  struct hd_volume_mass mass;
  struct hd_octree_level level[HD_OCTREE_MAX_LEVELS];
  struct hd_section section[HD_VOLUME_SECTIONS];
};

#endif /* HAPTICD_PROTO_VOLUME_H */
