/** @file
 * COLLADA: what assimp reads of it, and what it takes for something else.
 */
#pragma once

#include <string_view>

namespace hapticd_mesh_file {

/**
 * Throws MeshError for what assimp (5.2) makes another shape of: parts that are skewed or placed by "lookat", fans of
 * triangles, meshes with shape keys, skins that are put in place by a matrix of their own. `bytes` are the file; a
 * packed one (.zae) is refused.
 */
void requirePlainCollada(std::string_view bytes);

}  // namespace hapticd_mesh_file
