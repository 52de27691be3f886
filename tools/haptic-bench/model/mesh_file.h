/** @file
 * Triangles from a mesh file (tools/mesh_file) as a model.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/**
 * All meshes of the file as one; `scale` in metres per unit of the file. Throws Failure with the file and the reason,
 * also when it is interrupted.
 */
[[nodiscard]] Model readMeshFile(const std::string& path, double scale);

}  // namespace haptic_bench
