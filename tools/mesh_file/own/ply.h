/** @file
 * PLY files, read by ourselves. assimp (5.2) takes elements that it does not know for those that come after them, reads
 * strips of triangles as one triangle, and makes a mesh of a text that is cut short or has empty lines.
 */
#pragma once

#include <string>
#include <string_view>

#include "tools/mesh_file/polygons.h"

namespace hapticd_mesh_file {

/** Told by its first line; of a pipe by its name. */
[[nodiscard]] bool isPly(const std::string& path);

/**
 * Its vertices, faces and strips of triangles, in words or binary. Other elements and properties are passed over. Its
 * first line is not looked at. Throws MeshError. Any bytes can be given.
 */
[[nodiscard]] Polygons parsePly(std::string_view bytes);

}  // namespace hapticd_mesh_file
