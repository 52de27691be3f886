/** @file
 * STL files, in words or binary, read by ourselves. assimp (5.2) wants the very first word to be `solid` in small
 * letters and normals to be numbers, though nothing is made of them, leaves out a facet that has no end, and refuses a
 * binary file with a byte too many.
 */
#pragma once

#include <string_view>

#include "tools/mesh_file/polygons.h"

namespace hapticd_mesh_file {

/** All facets of all its solids; names, normals and colours are passed over. Throws MeshError. Any bytes can be given.
 */
[[nodiscard]] Polygons parseStl(std::string_view bytes);

}  // namespace hapticd_mesh_file
