/** @file
 * The flat form of a built mesh: one block of offsets and arrays that the builder writes, the daemon validates and the
 * servo reads in place. Also the upload format a client fills. Both cross process boundaries as sealed memfds.
 *
 * A snapshot is position independent: sections are byte offsets from its start, 64-byte aligned, in the order of
 * hd_snapshot_section. Lengths in metres, in the object's frame. Triangles are counter-clockwise seen from outside.
 */
#ifndef HAPTICD_PROTO_SNAPSHOT_H
#define HAPTICD_PROTO_SNAPSHOT_H

#include <stdint.h>

#define HD_SNAPSHOT_MAGIC UINT64_C(0x31504e5354504148) /**< "HAPTSNP1" */
#define HD_SNAPSHOT_VERSION 2u
#define HD_UPLOAD_MAGIC UINT64_C(0x3150554d54504148) /**< "HAPTMUP1" */

#define HD_NO_INDEX UINT32_C(0xffffffff)
#define HD_BVH_WIDTH 8u          /**< Children of a node: as many as a vector unit takes at once. */
#define HD_BVH_LEAF_TRIANGLES 8u /**< At most this many triangles in a leaf. */
#define HD_BVH_MAX_DEPTH 64u     /**< Deepest path, root included; the builder keeps it, the validator checks it. */
#define HD_MAX_VERTICES 16000000u
#define HD_MAX_TRIANGLES 16000000u
#define HD_MAX_COORDINATE 100.0f /**< Largest |coordinate| of a vertex [m]. */
#define HD_MIN_WELD 1e-6f        /**< Smallest and largest welding distance [m]. */
#define HD_MAX_WELD 0.01f
#define HD_MAX_DEFORM_VALENCE 128u /**< Most triangles about a vertex that can move: bounds the servo's refit. */

enum hd_snapshot_kind { HD_SNAPSHOT_TRIANGLES = 1 };

enum hd_snapshot_section {
  HD_SECTION_VERTICES = 0,   /**< float[3] per vertex. */
  HD_SECTION_TRIANGLES = 1,  /**< uint32[3] per triangle, in leaf order. */
  HD_SECTION_NEIGHBOURS = 2, /**< uint32[3] per triangle: across edges 01, 12, 20; HD_NO_INDEX at a border. */
  HD_SECTION_NODES = 3,      /**< hd_bvh_node; the root is node 0, children come after their parent. */
  HD_SECTION_PARENTS =
      4, /**< uint32 per node: its place, see below; HD_NO_INDEX for the root. Empty unless deformable. */
  HD_SECTION_VERTEX_FIRST = 5,     /**< uint32 per vertex + 1: start of its triangles. Empty unless deformable. */
  HD_SECTION_VERTEX_TRIANGLES = 6, /**< uint32: triangles about each vertex. Empty unless deformable. */
  HD_SECTION_TRIANGLE_LEAF = 7,    /**< uint32 per triangle: the place of its leaf. Empty unless deformable. */
  HD_SECTION_SOURCE_VERTEX =
      8,                  /**< uint32 per uploaded vertex: its vertex here after welding. Empty unless deformable. */
  HD_SECTION_CORNERS = 9, /**< float[3][3] per triangle: its vertices again, where the queries find them at once. */
  HD_SECTIONS = 10
};

/** Bits of hd_snapshot_header.flags. */
enum hd_snapshot_flag {
  HD_MESH_CLOSED = 1u << 0,    /**< Every edge has two triangles of one orientation: inside and outside exist. */
  HD_MESH_DEFORMABLE = 1u << 1 /**< The sections for vertex moves are present. */
};

struct hd_section {
  uint64_t offset; /**< From the start of the snapshot. */
  uint64_t bytes;
};

/*
 * The checksum finds damage (a cache file, a bad disk), not malice: every index is checked besides. FNV-1a takes 0.1 s
 * for the snapshot of a million triangles, one byte at a time; this takes its words in four lanes and 0.02 s.
 * total_bytes is a multiple of 64. Over the little-endian 64-bit words w[i] after the header:
 *   lane[i mod 4] = rotl((lane[i mod 4] ^ w[i]) * HD_CHECKSUM_PRIME, 29), each lane from HD_CHECKSUM_BASIS + its
 * number; sum = HD_CHECKSUM_BASIS; for each lane: sum = rotl((sum ^ lane) * HD_CHECKSUM_PRIME, 29). Each step is one to
 * one in the word, so any change of a single word changes the sum.
 */
#define HD_CHECKSUM_BASIS UINT64_C(0xcbf29ce484222325) /**< FNV-1a's offset basis. */
#define HD_CHECKSUM_PRIME UINT64_C(0x9e3779b97f4a7c15) /**< Odd, from the golden ratio. */

struct hd_snapshot_header {
  uint64_t magic;
  uint32_t version;
  uint32_t kind; /**< hd_snapshot_kind */
  uint64_t total_bytes;
  uint64_t checksum; /**< Of everything after this header, see below. */
  uint32_t flags;    /**< hd_snapshot_flag */
  uint32_t vertex_count;
  uint32_t triangle_count;
  uint32_t node_count;
  float lower[3]; /**< Bounding box. */
  float upper[3];
  uint32_t depth;       /**< Of the tree, root counted as 1. */
  uint32_t max_valence; /**< Most triangles about one vertex. */
  struct hd_section section[HD_SECTIONS];
};

/**
 * A node of a wide bounding volume hierarchy, four cache lines: the boxes of its children, coordinate by coordinate,
 * and where they are. The first `used` children count; the rest is zero. A child's place is HD_BVH_WIDTH * node +
 * number.
 */
struct hd_bvh_node {
  float lower[3][HD_BVH_WIDTH];
  float upper[3][HD_BVH_WIDTH];
  uint32_t child[HD_BVH_WIDTH]; /**< Of a leaf: its first triangle. Else: its node. */
  uint8_t count[HD_BVH_WIDTH];  /**< Of a leaf: its triangles, 1 to HD_BVH_LEAF_TRIANGLES. Else: 0. */
  uint32_t used;                /**< 1 to HD_BVH_WIDTH. */
  uint32_t reserved[5];
};

/** Start of an upload: vertices then triangles follow at once, tightly packed. */
struct hd_mesh_upload {
  uint64_t magic;
  uint32_t vertex_count;
  uint32_t triangle_count;
  uint32_t flags; /**< HD_MESH_DEFORMABLE, and those of volume.h. */
  float weld_m;   /**< Vertices no farther apart become one: HD_MIN_WELD to HD_MAX_WELD, or 0: equal ones only. */
  /* float vertices[vertex_count][3]; uint32_t triangles[triangle_count][3]; */
};

#endif /* HAPTICD_PROTO_SNAPSHOT_H */
