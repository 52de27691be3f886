#include "tools/mesh_file/read_mesh.h"

#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>

#include "tools/mesh_file/child.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"
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
  if (::access(path.c_str(), R_OK) != 0) throw MeshError(std::generic_category().message(errno));
  // Opened here and again, a pipe's writer would have lost its reader. Of the other formats much is read twice.
  if (!std::filesystem::is_regular_file(status) && !endsWith(path, ".stl") && !endsWith(path, ".ply") &&
      !endsWith(path, ".off"))
    throw MeshError("is no file on a disk, and is read more than once", "write it into one first");
}

/** What reading it may take [B]. Packed files of a megabyte unfold to gigabytes if they are made to. */
std::uint64_t mostMemory(const std::string& path) {
  constexpr std::uint64_t kAlways = std::uint64_t{2} << 30, kTimes = 200;  // Of XML it is some 80 times.
  char head[4] = {};
  if (!std::filesystem::is_regular_file(path)) return std::numeric_limits<std::uint64_t>::max();
  std::ifstream(path, std::ios::binary).read(head, sizeof head);
  const bool packed = std::string_view(head, 4) == "PK\3\4" || std::string_view(head, 2) == "\x1f\x8b";
  return packed ? kAlways + kTimes * std::filesystem::file_size(path) : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

MeshFile readMesh(const std::string& path, std::string_view program, const std::function<bool()>& interrupted) {
  checkReadable(path);
  MeshFile mesh = readInChild([&] { return readScene(path, program); }, interrupted, mostMemory(path));
  mesh.path = path;
  return mesh;
}

}  // namespace hapticd_mesh_file
