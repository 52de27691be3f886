#include "tools/mesh_file/mesh_file.h"

#include <algorithm>
#include <limits>

namespace hapticd_mesh_file {

void measure(MeshFile& mesh) {
  mesh.lower.fill(std::numeric_limits<double>::infinity());
  mesh.upper.fill(-std::numeric_limits<double>::infinity());
  for (const auto& v : mesh.vertices) {
    for (std::size_t i = 0; i < 3; ++i) {
      mesh.lower[i] = std::min<double>(mesh.lower[i], v[i]);
      mesh.upper[i] = std::max<double>(mesh.upper[i], v[i]);
    }
  }
}

}  // namespace hapticd_mesh_file
