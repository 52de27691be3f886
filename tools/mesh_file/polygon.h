/** @file
 * A polygon as triangles.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace hapticd_mesh_file {

/**
 * Cuts a polygon of at least three corners into all its triangles but one fewer than that, in its winding: ears, none
 * of which holds another corner, not on its border either. So an L whose inner corner lies in a line with two others
 * is not lidded, and a corner on a straight side is one of its triangles. Hollows that are joined to the rim by a
 * doubled edge stay hollow. Of a polygon that crosses itself or is no wider than a line some triangles overlap or have
 * no area.
 *
 * @param corners  Where they are.
 * @return  Three numbers of corners each.
 */
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> trianglesOf(const std::vector<std::array<float, 3>>& corners);

}  // namespace hapticd_mesh_file
