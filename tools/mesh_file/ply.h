/** @file
 * PLY files, read by ourselves. assimp (5.2) takes elements that it does not know for those that come after them, reads
 * strips of triangles as one triangle, and makes a mesh of a text that is cut short or has empty lines.
 */
#pragma once

#include <memory>
#include <string>
#include <string_view>

struct aiScene;

namespace hapticd_mesh_file {

/** Told by its first line. */
[[nodiscard]] bool isPly(const std::string& path);

/**
 * Its vertices, faces and strips of triangles, in words or binary, as assimp would hand them on: one mesh at the root.
 * Other elements and properties are passed over. Numbers of vertices may be too large. Throws MeshError.
 */
[[nodiscard]] std::unique_ptr<aiScene> readPly(const std::string& path);
/** The same of what a file holds; the first line is not looked at. */
[[nodiscard]] std::unique_ptr<aiScene> parsePly(std::string_view bytes);

}  // namespace hapticd_mesh_file
