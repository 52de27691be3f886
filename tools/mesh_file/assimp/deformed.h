/** @file
 * Where the vertices of a scene are seen: morph targets and joints may have moved them from where they are stored.
 */
#pragma once

#include <assimp/scene.h>

#include <vector>

namespace hapticd_mesh_file {

/** A mesh's vertices in the scene. */
struct Places {
  std::vector<aiVector3D> vertices;
  bool mirrored = false;  ///< Its triangles are inside out.
};

/** Of a mesh that a node shows: where the node is. */
[[nodiscard]] Places placedBy(const aiMesh& mesh, const aiMatrix4x4& world);

/**
 * The same with its morph targets by their default weights and, if it has a skin, where its joints are at rest,
 * whatever its node is, as glTF 2.0 has it (3.7.3.3). Throws MeshError if a joint's name is that of no node or of
 * several.
 */
[[nodiscard]] Places deformed(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& world);

/**
 * Of a mesh that is read where its node is: throws MeshError if the joints of its skin put it elsewhere. Of joints
 * whose nodes or places cannot be told nothing is known.
 */
void requireAtRest(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& world);

}  // namespace hapticd_mesh_file
