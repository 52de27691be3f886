/** @file
 * A flat side of a mesh, of one triangle or cut into many, and what is nearer beyond its ridges. Of proxy*.cc only.
 */
#pragma once

#include <cstdint>

#include "rt/render/proxy/seen_face.h"

namespace hapticd {

inline constexpr int kMaxOfSide = 48;  // Triangles.

/** How far x is from the edge of the triangle that begins at `corner`. */
[[nodiscard]] double distanceToEdge(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner,
                                    const Vec3& x) HD_RT;

/** What nearerThanSide() finds where a neighbour lies in one plane with the face, or some plane is nearer. */
[[nodiscard]] std::uint32_t nearerOfSide(const SeenFace& face, const Vec3& hip, double depth, int most,
                                         std::uint32_t& work) HD_RT;

/**
 * Of a face that has sought the hip, above its foot and `depth` below it, and of all that lie in one plane with it
 * about that foot, `most` at most: of the planes beyond their ridges that are nearer to the hip the nearest. However a
 * flat side is cut, and in whatever order its corners are, it is the same. HD_NO_INDEX: there is none.
 */
[[nodiscard]] inline std::uint32_t nearerThanSide(const SeenFace& f, const Vec3& hip, double depth, int most,
                                                  std::uint32_t& work) HD_RT {
  if (!(depth > 0)) return HD_NO_INDEX;
  for (int k = 0; k < 3; ++k) {
    Vec3 opposite;
    if (!f.isNear(k, depth) || !f.beyond(k, opposite)) continue;
    const double rise = f.up.dot(opposite);
    bool asks = rise * rise <= kFlat * f.up2 * opposite.squaredNorm();  // Else surely not flat.
    if (!asks && rise < 0) {
      const double height = -opposite.dot(f.along[k].cross(hip - f.v[k]));
      asks = height > 0 && height * height < depth * depth * area2(opposite, f.along[k]);
    }
    if (asks) return nearerOfSide(f, hip, depth, most, work);
  }
  return HD_NO_INDEX;
}

}  // namespace hapticd
