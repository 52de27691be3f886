/** @file
 * Normals of edges and vertices that tell inside from outside.
 */
#pragma once

#include "rt/geometry/feature.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

inline constexpr int kMaxFan = 128;
inline constexpr double kNoCrease = -2;  ///< Below every cosine.

/** Unit; zero for a triangle without area. */
[[nodiscard]] Vec3 faceNormal(const MeshView& mesh, std::uint32_t triangle) HD_RT;

/**
 * The angle-weighted pseudo-normal of a triangle's face, edge or vertex (Baerentzen and Aanaes, "Signed distance
 * computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005): if a closed mesh's point nearest to x
 * lies there, x is outside exactly when it is on this normal's side. Unit, or zero if the triangles about cancel.
 * `work` grows by the triangles visited; of a vertex with more than kMaxFan triangles the first so many in each
 * direction are taken. About a vertex the triangles are taken as far as the edges between them bend by less than
 * `crease_cosine` says: by default all. Vertices that rounding to floats cannot tell apart count as one. Servo-safe.
 */
[[nodiscard]] Vec3 pseudoNormal(const MeshView& mesh, std::uint32_t triangle, FeatureKind kind, std::uint32_t corner,
                                std::uint32_t& work, double crease_cosine = kNoCrease) HD_RT;

}  // namespace hapticd
