/** @file
 * What the ending of a file's name promises.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace hapticd_options {

/** Whether a file made there would pass for one of another format for meshes or volumes than `own`, as ".ply". */
inline bool promisesAnother(const std::string& path, std::string_view own) {
  constexpr std::array<std::string_view, 15> kFormats = {".ply", ".vdb", ".stl",  ".obj", ".off",
                                                         ".x3d", ".3ds", ".gltf", ".glb", ".dae",
                                                         ".3mf", ".amf", ".dxf",  ".fbx", ".nii"};
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  std::error_code none;
  const bool file = !std::filesystem::exists(path, none) || std::filesystem::is_regular_file(path, none);
  return file && ending != own && std::find(kFormats.begin(), kFormats.end(), ending) != kFormats.end();
}

}  // namespace hapticd_options
