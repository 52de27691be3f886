#include "tools/mesh_file/read_mesh.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "tools/mesh_file/child.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/scene.h"
#include "tools/mesh_file/words.h"

namespace hapticd_mesh_file {
namespace {

void checkReadable(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error && error != std::errc::no_such_file_or_directory) throw MeshError(error.message());
  if (!std::filesystem::exists(status)) throw MeshError("no such file");
  if (std::filesystem::is_directory(status)) throw MeshError("is a directory, not a mesh file");
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(path, error) == 0) {
    throw MeshError("is empty");
  }
  if (::access(path.c_str(), R_OK) != 0) throw MeshError(std::generic_category().message(errno));
  // Opened here and again, a pipe's writer would have lost its reader. Of the other formats much is read twice.
  if (!std::filesystem::is_regular_file(status) && !endsWith(path, ".stl") && !endsWith(path, ".ply") &&
      !endsWith(path, ".off"))
    throw MeshError("is no file on a disk, and is read more than once", "write it into one first");
}

}  // namespace

MeshFile readMesh(const std::string& path, std::string_view program, const std::function<bool()>& interrupted) {
  checkReadable(path);
  MeshFile mesh = readInChild([&] { return readScene(path, program); }, interrupted);
  mesh.path = path;
  return mesh;
}

}  // namespace hapticd_mesh_file
