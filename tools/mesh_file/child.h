/** @file
 * Reads a mesh in a process of its own: what a damaged file does to the library that reads it ends there.
 */
#pragma once

#include <functional>

#include "tools/mesh_file/mesh_file.h"

namespace hapticd_mesh_file {

/**
 * What `read` returns or throws as MeshError, of a child process; the path is lost. Throws MeshError if that dies, or
 * is ended because `interrupted` said so.
 */
[[nodiscard]] MeshFile readInChild(const std::function<MeshFile()>& read, const std::function<bool()>& interrupted);

}  // namespace hapticd_mesh_file
