/** @file
 * From a file's name to its triangles, whatever the file is.
 */
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "tools/mesh_file/mesh_file.h"

namespace hapticd_mesh_file {

/**
 * Reads and merges, in a child process: no other thread may run. Throws MeshError that says what is wrong: unreadable,
 * unknown format, damaged, no triangles (points or lines only), a vertex that is not finite (and which).
 *
 * @param program  Who reads, for remedies.
 * @param interrupted  Whether the user wants it to end, asked every few milliseconds: some files keep assimp for ever.
 */
[[nodiscard]] MeshFile readMesh(const std::string& path, std::string_view program,
                                const std::function<bool()>& interrupted);

}  // namespace hapticd_mesh_file
