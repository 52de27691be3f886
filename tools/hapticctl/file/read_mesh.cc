#include "tools/hapticctl/file/read_mesh.h"

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/read_mesh.h"

namespace hapticctl {

MeshFile readMesh(const std::string& path) {
  try {
    return hapticd_mesh_file::readMesh(path, "hapticctl", Interrupt::asked);
  } catch (const hapticd_mesh_file::MeshError& error) {
    if (error.code == hapticd_mesh_file::kCancelled)
      throw Failure{kExitRefused, path, "cancelled; nothing was loaded", {}, error.code};
    throw Failure{kExitFile, path, error.what(), error.remedy, error.code};
  }
}

}  // namespace hapticctl
