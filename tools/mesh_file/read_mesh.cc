#include "tools/mesh_file/read_mesh.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "tools/mesh_file/child.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/scene.h"

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
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  if (file == nullptr) throw MeshError(std::generic_category().message(errno));
  std::fclose(file);
}

}  // namespace

MeshFile readMesh(const std::string& path, std::string_view program, const std::function<bool()>& interrupted) {
  checkReadable(path);
  MeshFile mesh = readInChild([&] { return readScene(path, program); }, interrupted);
  mesh.path = path;
  return mesh;
}

}  // namespace hapticd_mesh_file
