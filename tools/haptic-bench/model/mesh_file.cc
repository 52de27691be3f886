#include "tools/haptic-bench/model/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/Importer.hpp>
#include <cmath>

#include "proto/snapshot.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

Model readMeshFile(const std::string& path, double scale) {
  Assimp::Importer importer;
  // Each node's transform applied; equal corners joined, for the file may give each triangle its own.
  const aiScene* scene = importer.ReadFile(path, aiProcess_PreTransformVertices | aiProcess_Triangulate |
                                                     aiProcess_DropNormals | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr) throw Failure(path, importer.GetErrorString(), "a mesh file: STL, OBJ, PLY ...");
  Model model;
  model.kind = "file";
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const auto base = static_cast<std::uint32_t>(model.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const Vec3 x = scale * Vec3(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
      if (!(x.cwiseAbs().maxCoeff() <= HD_MAX_COORDINATE)) {
        throw Failure(path, fmt::format("vertex {} of mesh {} lies {:.4g} m away", v, m, x.norm()),
                      fmt::format("at most {} m: the file's unit may be another, add :scale=0.001", HD_MAX_COORDINATE));
      }
      model.addVertex(x);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // Points and lines.
      model.triangles.push_back({base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
    }
  }
  if (model.triangles.empty()) throw Failure(path, "there are no triangles in it", "a surface, not points or lines");
  return model;
}

}  // namespace haptic_bench
