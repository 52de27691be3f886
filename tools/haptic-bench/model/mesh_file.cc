#include "tools/haptic-bench/model/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>

#include "proto/snapshot.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

Model readMeshFile(const std::string& path, double scale) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, aiProcess_PreTransformVertices | aiProcess_Triangulate);
  if (scene == nullptr) throw Failure(path, importer.GetErrorString(), "a mesh file: STL, OBJ, PLY ...");
  Model model;
  model.kind = "file";
  // Corners in one place are one vertex, whatever the file has them wear: normals, textures, materials of their own.
  std::map<std::array<float, 3>, std::uint32_t> places;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    std::vector<std::uint32_t> number;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const Vec3 x = scale * Vec3(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
      if (!(x.cwiseAbs().maxCoeff() <= HD_MAX_COORDINATE)) {
        throw Failure(path, fmt::format("vertex {} of mesh {} lies {:.4g} m away", v, m, x.norm()),
                      fmt::format("at most {} m: the file's unit may be another, add :scale=0.001", HD_MAX_COORDINATE));
      }
      const Eigen::Vector3f rounded = x.cast<float>();
      const auto [place, fresh] = places.try_emplace({rounded.x(), rounded.y(), rounded.z()}, 0);
      if (fresh) place->second = model.addVertex(x);
      number.push_back(place->second);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // Points and lines.
      model.triangles.push_back({number[face.mIndices[0]], number[face.mIndices[1]], number[face.mIndices[2]]});
    }
  }
  if (model.triangles.empty()) throw Failure(path, "there are no triangles in it", "a surface, not points or lines");
  return model;
}

}  // namespace haptic_bench
