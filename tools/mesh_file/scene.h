/** @file
 * A file as one mesh, read by ourselves or by assimp.
 */
#pragma once

#include <string>
#include <string_view>

#include "tools/mesh_file/mesh_file.h"

namespace hapticd_mesh_file {

/** In this process, which a damaged file may end or keep for ever: assimp trusts it. Throws MeshError. */
[[nodiscard]] MeshFile readScene(const std::string& path, std::string_view program);

}  // namespace hapticd_mesh_file
