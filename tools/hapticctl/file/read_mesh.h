/** @file
 * Mesh files as hapticctl reads them: refused in its own way, given up at a signal.
 */
#pragma once

#include <string>

#include "tools/mesh_file/mesh_file.h"

namespace hapticctl {

using hapticd_mesh_file::MeshFile;

/** Reads and merges. Throws Failure that names the file and what is wrong: kExitFile, or kExitRefused at a signal. */
[[nodiscard]] MeshFile readMesh(const std::string& path);

}  // namespace hapticctl
