// PLY files: whatever they hold, refused with words or a mesh whose faces are whole.
#include <assimp/scene.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd_mesh_file;
  try {
    const auto scene = parsePly({reinterpret_cast<const char*>(data), size});
    if (scene->mNumMeshes != 1 || scene->mRootNode->mNumMeshes != 1) std::abort();
    const aiMesh& mesh = *scene->mMeshes[0];
    std::size_t corners = 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      for (unsigned i = 0; i < face.mNumIndices; ++i) corners += face.mIndices[i] < mesh.mNumVertices ? 1 : 0;
    }
    if (corners > 3 * size || mesh.mNumVertices > size) std::abort();  // Each takes a byte; of a strip's each thrice.
  } catch (const MeshError& error) {
    if (*error.what() == 0 || error.remedy.empty()) std::abort();
  }
  return 0;
}
