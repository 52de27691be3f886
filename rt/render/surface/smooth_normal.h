/** @file
 * The normal of the smooth surface that a coarse mesh stands for: normals of its corners, interpolated.
 */
#pragma once

#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * The mesh as a smooth sheet: a point of a facet has the normal interpolated between its corners', each the mean of the
 * facets about it weighted by their angles, as far as no edge between bends by more than `crease_cosine` says. `side`
 * -1: seen from behind.
 */
struct SmoothSheet {
  const MeshView& mesh;
  double crease_cosine;
  double side;

  /**
   * The normal at the place from which x lies along the normal itself (Kobbelt, Campagna, Vorsatz, Seidel, "Interactive
   * multi-resolution modeling on arbitrary meshes", SIGGRAPH 1998: Phong projection), sought from `triangle` on over
   * edges that are no creases: it turns steadily with x wherever facets meet, above the sheet and below, down to three
   * quarters of its radius of curvature. Beyond a crease or border the place stays on it. Unit; zero where the corners
   * tell none. `work` grows by the triangles visited. Servo-safe: at most kMaxFaces, and where fans are large as many
   * as kMaxWork and a fan.
   */
  [[nodiscard]] Vec3 normalToward(const Vec3& x, std::uint32_t triangle, std::uint32_t& work) const HD_RT;
  /** Whether the surface goes on over that edge, and round. */
  [[nodiscard]] bool isSmooth(std::uint32_t triangle, std::uint32_t edge) const HD_RT;

  /** What meets at a vertex. */
  struct Corner {
    int creases = 0;
    bool border = false;
    /** At a border the facets beside it. Else of each side of two creases that which faces a normal most. */
    std::uint32_t facet[2] = {HD_NO_INDEX, HD_NO_INDEX};
  };
  /** About the triangle's vertex, up to kMaxFan triangles. `work` grows by them. Servo-safe. */
  [[nodiscard]] Corner cornerAt(std::uint32_t triangle, std::uint32_t corner, const Vec3& normal,
                                std::uint32_t& work) const HD_RT;

  static constexpr int kMaxFaces = 8;
  static constexpr std::uint32_t kMaxWork = 3 * (2 * 128 + 1);  ///< Three of the largest fans.
};

}  // namespace hapticd
