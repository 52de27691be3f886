#include "tools/mesh_file/assimp/deformed.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

std::vector<const aiNode*> named(const aiNode& node, const aiString& name) {
  std::vector<const aiNode*> found;
  std::vector<const aiNode*> open{&node};
  while (!open.empty()) {
    const aiNode* const next = open.back();
    open.pop_back();
    if (next->mName == name) found.push_back(next);
    open.insert(open.end(), next->mChildren, next->mChildren + next->mNumChildren);
  }
  return found;
}

/** Where a joint takes what is bound to it. */
aiMatrix4x4 jointOf(const aiScene& scene, const aiBone& bone) {
  const auto nodes = named(*scene.mRootNode, bone.mName);
  if (nodes.size() != 1) {
    throw MeshError(fmt::format("has a skin with a joint '{}', and {} nodes of that name",
                                shown(bone.mName.C_Str(), 60), nodes.size()),
                    "give its joints names of their own, or apply its armature before the export", kBadMesh);
  }
  aiMatrix4x4 world = bone.mOffsetMatrix;
  for (const aiNode* node = nodes.front(); node != nullptr; node = node->mParent) world = node->mTransformation * world;
  return world;
}

/** With as much of each morph target as it has by default. */
std::vector<aiVector3D> morphed(const aiMesh& mesh) {
  std::vector<aiVector3D> places(mesh.mVertices, mesh.mVertices + mesh.mNumVertices);
  for (unsigned t = 0; t < mesh.mNumAnimMeshes; ++t) {
    const aiAnimMesh& target = *mesh.mAnimMeshes[t];
    if (!target.HasPositions() || target.mNumVertices != mesh.mNumVertices) continue;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      places[v] += (target.mVertices[v] - mesh.mVertices[v]) * target.mWeight;
  }
  return places;
}

}  // namespace

Places placedBy(const aiMesh& mesh, const aiMatrix4x4& world) {
  Places out{{mesh.mVertices, mesh.mVertices + mesh.mNumVertices}, world.Determinant() < 0};
  for (aiVector3D& place : out.vertices) place *= world;
  return out;
}

namespace {

/** Vertices as stored, where joints put them. */
Places skinned(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& world,
               const std::vector<aiVector3D>& stored) {
  Places out{std::vector<aiVector3D>(stored.size()), world.Determinant() < 0};
  std::vector<float> weights(stored.size());
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const aiMatrix4x4 joint = jointOf(scene, bone);
    if (b == 0) out.mirrored = joint.Determinant() < 0;
    for (unsigned i = 0; i < bone.mNumWeights; ++i) {
      const auto [v, weight] = std::pair(bone.mWeights[i].mVertexId, bone.mWeights[i].mWeight);
      if (v >= stored.size()) refuse("has a skin for vertices that are not there");
      out.vertices[v] += joint * stored[v] * weight;
      weights[v] += weight;
    }
  }
  for (std::size_t v = 0; v < stored.size(); ++v)
    out.vertices[v] = weights[v] > 0 ? out.vertices[v] / weights[v] : world * stored[v];
  return out;
}

}  // namespace

Places deformed(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& world) {
  return skinned(scene, mesh, world, morphed(mesh));
}

void requireAtRest(const aiScene& scene, const aiMesh& mesh, const aiMatrix4x4& world) {
  if (!mesh.HasBones() || mesh.mNumVertices == 0) return;
  for (unsigned b = 0; b < mesh.mNumBones; ++b)  // assimp has none where a COLLADA leaves out <bind_shape_matrix>.
    if (mesh.mBones[b]->mOffsetMatrix.Determinant() == 0) return;
  const Places read = placedBy(mesh, world);
  Places seen;
  try {
    seen = skinned(scene, mesh, world, {mesh.mVertices, mesh.mVertices + mesh.mNumVertices});
  } catch (const MeshError&) {
    return;
  }
  aiVector3D lower = read.vertices.front(), upper = lower;
  for (const aiVector3D& v : read.vertices) {
    lower = {std::min(lower.x, v.x), std::min(lower.y, v.y), std::min(lower.z, v.z)};
    upper = {std::max(upper.x, v.x), std::max(upper.y, v.y), std::max(upper.z, v.z)};
  }
  constexpr float kRounding = 1e-3f;  // Of the mesh: of matrices written in few digits.
  const float most = kRounding * (upper - lower).Length();
  for (std::size_t v = 0; v < read.vertices.size(); ++v) {
    if ((seen.vertices[v] - read.vertices[v]).Length() <= most) continue;
    throw MeshError("holds a skin that its joints have moved from its rest, which is not read",
                    "apply its armature before the export, or export it as glTF", kBadMesh);
  }
}

}  // namespace hapticd_mesh_file
