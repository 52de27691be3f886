/** @file
 * The triangles of a mesh file (STL, OBJ, PLY, OFF, X3D, 3DS, glTF and what else assimp reads), as our programs want
 * them.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace hapticd_mesh_file {

/** One indexed mesh. Coordinates in the file's own unit. */
struct MeshFile {
  std::string path;
  std::vector<std::array<float, 3>> vertices;  ///< Equal positions are one vertex.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::array<double, 3> lower{}, upper{};  ///< Box of the vertices.
  std::size_t meshes = 0;   ///< How many of the file's meshes were merged, each through its node transforms.
  std::size_t skipped = 0;  ///< Points and lines left out.
};

/** Sets the box, of vertices that were changed. */
void measure(MeshFile& mesh);

}  // namespace hapticd_mesh_file
