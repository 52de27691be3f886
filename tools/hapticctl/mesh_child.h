/** @file
 * Reads a mesh in a process of its own: what a damaged file does to the library that reads it ends there.
 */
#pragma once

#include <functional>
#include <string>

#include "tools/hapticctl/mesh_file.h"

namespace hapticctl {

/** What `read` returns or throws, of a child process. Throws Failure (kExitFile) naming `path` if that dies. */
[[nodiscard]] MeshFile readInChild(const std::string& path, const std::function<MeshFile()>& read);

}  // namespace hapticctl
