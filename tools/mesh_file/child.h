/** @file
 * Reads a mesh in a process of its own: what a damaged file does to the library that reads it ends there.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <limits>

#include "tools/mesh_file/mesh_file.h"

namespace hapticd_mesh_file {

/**
 * What `read` returns or throws as MeshError, of a child process; the path is lost. Throws MeshError if that dies, or
 * is ended because `interrupted` said so, or asks for more than `most_bytes` of memory, or than the machine has.
 */
[[nodiscard]] MeshFile readInChild(const std::function<MeshFile()>& read, const std::function<bool()>& interrupted,
                                   std::uint64_t most_bytes = std::numeric_limits<std::uint64_t>::max());

}  // namespace hapticd_mesh_file
