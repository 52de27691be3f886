/** @file
 * A snapshot (proto/snapshot.h) as the servo reads it: typed pointers into a validated, locked mapping.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/snapshot.h"
#include "rt/base/contract.h"
#include "rt/base/error.h"
#include "rt/base/math.h"

namespace hapticd {

class Refit;
struct VertexMotion;

/**
 * Triangles with their tree. Does not own the memory: whoever published the view keeps it until the servo has passed.
 * For a deformable mesh the arrays are a private writable copy and `deform` is set; otherwise they are read-only.
 */
struct MeshView {
  using Float3 = float[3];
  using Index3 = std::uint32_t[3];
  using Corners = float[3][3];

  /** What vertex moves need; all null for a rigid mesh. */
  struct Deform {
    Float3* vertices = nullptr;
    Corners* corners = nullptr;
    hd_bvh_node* nodes = nullptr;
    const std::uint32_t* parents = nullptr;
    const std::uint32_t* vertex_first = nullptr;
    const std::uint32_t* vertex_triangles = nullptr;
    const std::uint32_t* triangle_leaf = nullptr;
    const std::uint32_t* source_vertex = nullptr;
    std::uint32_t source_count = 0;
    std::uint64_t moves = 0;         ///< Of vertices, so far.
    VertexMotion* motion = nullptr;  ///< Of each vertex; null: none is known.
    double moved = 0;                ///< When any moved last, on the scene's clock [s].
    std::uint64_t noted = 0;         ///< The advance() of the scene for which it noted any of them; 0: none.
  };

  const Float3* vertices = nullptr;
  const Index3* triangles = nullptr;
  const Index3* neighbours = nullptr;
  const hd_bvh_node* nodes = nullptr;
  const Corners* corners = nullptr;  ///< Of each triangle: its vertices, in one place.
  std::uint32_t vertex_count = 0;
  std::uint32_t triangle_count = 0;
  std::uint32_t node_count = 0;
  std::uint32_t depth = 0;
  std::uint32_t flags = 0;  ///< hd_snapshot_flag
  Deform deform;

  /** Corner c of triangle t, in the object's frame [m]. */
  [[nodiscard]] Vec3 vertex(std::uint32_t t, int c) const HD_RT {
    const Float3& x = corners[t][c];
    return {x[0], x[1], x[2]};
  }
};

/**
 * Checks a whole snapshot (magic, version, checksum, sections, every index, tree shape, boxes finite) and points into
 * it. Control thread. The bytes must not change afterwards (sealed). kBadSnapshot says what and where.
 */
[[nodiscard]] Result<MeshView> validateSnapshot(std::span<const std::byte> bytes);

/**
 * Moves one vertex and refits the boxes above its triangles. Bounded by valence times depth. `vertex` counts as in the
 * upload. kNotFound for an index out of range, kUnsupported for a rigid mesh, kInvalidArgument if not finite.
 */
ErrorCode moveVertex(MeshView& mesh, std::uint32_t vertex, const float (&p)[3]) HD_RT;
/** The same, one of several: the boxes are left to `refit`, which is of this mesh. */
ErrorCode moveVertex(MeshView& mesh, std::uint32_t vertex, const float (&p)[3], Refit& refit) HD_RT;
/** What they would answer. */
ErrorCode mayMoveVertex(const MeshView& mesh, std::uint32_t vertex, const float (&p)[3]) HD_RT;

}  // namespace hapticd
