/** @file
 * Triangles without area, as exports and closers of T-junctions leave them.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace hapticd_mesh_file {

using Vertex = std::array<float, 3>;
using Triangle = std::array<std::uint32_t, 3>;  ///< Numbers of vertices.

/**
 * The same surface from triangles with an area, as mesh processing tools mend it (needles collapse, caps flip):
 * corners of a flat triangle that lie in one place become one; a corner that lies on the opposite edge becomes a corner
 * of the triangle beyond that edge, too. Flat is what is no higher than a ten millionth of its longest side, and no
 * point moves by more than a millionth of such a side. What cannot be mended so (a flat triangle about whose corner and
 * the one beyond there is an edge already) stays; see isFlat().
 */
[[nodiscard]] std::vector<Triangle> withoutFlatTriangles(const std::vector<Vertex>& vertices,
                                                         std::vector<Triangle> triangles);

/** Whether it has no area to speak of. */
[[nodiscard]] bool isFlat(const std::vector<Vertex>& vertices, const Triangle& triangle);

}  // namespace hapticd_mesh_file
