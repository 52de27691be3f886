/** @file
 * Triangles from a mesh file, in whatever format assimp reads.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** All meshes of the file as one; `scale` in metres per unit of the file. Throws Failure with the file and the reason.
 */
[[nodiscard]] Model readMeshFile(const std::string& path, double scale);

}  // namespace haptic_bench
