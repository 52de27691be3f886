#include "tools/mesh_file/assimp/collada.h"

#include <fmt/format.h>

#include <pugixml.hpp>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

bool isIdentity(std::string_view matrix) {
  for (int i = 0; i < 16; ++i)
    if (numberIn(takeWord(matrix)) != (i % 5 == 0 ? 1.0 : 0.0)) return false;
  return takeWord(matrix).empty();
}

}  // namespace

void requirePlainCollada(std::string_view bytes) {
  if (bytes.starts_with("PK"))  // What lies in it, this does not see.
    throw MeshError("is a packed COLLADA file, which is not read", "unpack it (unzip), and take the .dae file in it",
                    kBadMesh);
  pugi::xml_document file;
  if (!file.load_buffer(bytes.data(), bytes.size())) return;  // assimp says why.
  // Of a camera or a lamp it does not matter.
  constexpr const char* kShown = "[.//instance_geometry or .//instance_controller or .//instance_node]";
  for (const char* const way : {"skew", "lookat"}) {
    if (!file.select_node(fmt::format("//node[{}]{}", way, kShown).c_str())) continue;
    throw MeshError(fmt::format("places its parts by <{}>, which is not read", way),
                    "export it with its transforms applied, or as another format", kBadMesh);
  }
  if (file.select_node("//trifans"))
    throw MeshError("holds fans of triangles (<trifans>), which are not read", "export single triangles", kBadMesh);
  if (file.select_node("//controller/morph"))
    throw MeshError("holds a mesh with shape keys (<morph>), which is not read",
                    "apply its shape keys before the export, or export it as glTF", kBadMesh);
  for (const auto& matrix : file.select_nodes("//skin/bind_shape_matrix")) {
    if (isIdentity(matrix.node().child_value())) continue;
    throw MeshError("holds a skin with a place of its own (<bind_shape_matrix>), which is not read",
                    "apply its armature before the export, or export another format", kBadMesh);
  }
}

}  // namespace hapticd_mesh_file
