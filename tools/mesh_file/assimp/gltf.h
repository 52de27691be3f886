/** @file
 * What assimp (5.2) passes over in glTF files: the extensions without which their numbers mean something else, faces
 * with vertices that are not there, and names of files with blanks or umlauts.
 */
#pragma once

#include <string>
#include <string_view>

namespace hapticd_mesh_file {

/** Told by the file's name, .gltf or .glb. */
[[nodiscard]] bool isGltf(const std::string& path);

/**
 * Throws MeshError if a file needs an extension that changes its surface and is not read, quantized coordinates or
 * instances, say, or has a node that morphs its mesh otherwise than the mesh itself says. Of bytes that are no glTF it
 * says nothing. Any bytes can be given.
 */
void requirePlainGltf(std::string_view bytes);

/** Hears whether assimp leaves out faces, as it does in silence with those whose vertices are not there. One at a time.
 */
class LostFaces {
 public:
  LostFaces();
  LostFaces(const LostFaces&) = delete;
  LostFaces& operator=(const LostFaces&) = delete;
  ~LostFaces();

  [[nodiscard]] bool any() const { return any_; }

 private:
  bool any_ = false;
};

/** "my%20part.bin" as the name of a file; what is no code stays as it is. */
[[nodiscard]] std::string percentDecoded(std::string_view uri);

}  // namespace hapticd_mesh_file
