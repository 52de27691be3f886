/** @file
 * Why a mesh file gives no mesh. Each program makes its own failure of it, with the file's name.
 */
#pragma once

#include <stdexcept>
#include <string>

namespace hapticd_mesh_file {

/** what() is wrong with the file, and what to do about it. */
class MeshError : public std::runtime_error {
 public:
  explicit MeshError(const std::string& what, std::string remedy_ = {}, std::string code_ = {})
      : std::runtime_error(what), remedy(std::move(remedy_)), code(std::move(code_)) {}

  std::string remedy;  ///< May be empty.
  std::string code;    ///< Name in proto/errors.h, may be empty; kCancelled where the user has interrupted.
};

constexpr const char* kBadMesh = "BAD_MESH";
constexpr const char* kCancelled = "CANCELLED";

}  // namespace hapticd_mesh_file
