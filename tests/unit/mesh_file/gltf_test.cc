// glTF: what assimp passes over in it.
#include "tools/mesh_file/gltf.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/mesh_file/mesh_files.h"

namespace hapticd_mesh_file {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/** One triangle, with what else its description says. */
std::string gltf(const std::string& more, const std::string& buffer) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)" + more +
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" +
         buffer + "\"}]}";
}
/** Around a description. */
std::string glb(std::string json) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 255u);
    return bytes;
  };
  return "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json;
}
constexpr const char* kTriangleInside =
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";

// assimp took coordinates in 16 bits for floats, and of a hundred instances showed one.
TEST_F(ReadMeshTest, AGltfThatNeedsWhatIsNotReadIsRefused) {
  for (const char* const needed : {"KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"}) {
    const std::string text =
        gltf(fmt::format(R"("extensionsRequired":["KHR_materials_unlit","{}"],)", needed), kTriangleInside);
    const std::string expected = fmt::format("needs the extension {}, which is not read", needed);
    EXPECT_EQ(refusal(file("a.gltf", "\xef\xbb\xbf" + text)), expected);
    EXPECT_EQ(refusal(file("a.GLB", glb(text))), expected);
  }
  EXPECT_THAT(refusal(file("a.gltf", gltf(R"("extensionsUsed":["EXT_mesh_gpu_instancing"],)", kTriangleInside))),
              HasSubstr("EXT_mesh_gpu_instanc"));
  for (const char* const fine :
       {R"("extensionsRequired":["KHR_materials_unlit"],"extensionsUsed":["KHR_mesh_quantization"],)",
        R"("extensionsRequired":[],)", ""})
    EXPECT_EQ(refusal(file("a.gltf", gltf(fine, kTriangleInside))), "not refused");
  for (const std::string broken :
       {"glTF", "glTF\2\2\2\2\2\2\2\2\377\377\377\377JSON{", "{", "[1]", R"({"extensionsRequired":{"a":1}})"})
    EXPECT_NE(refusal(file("a.glb", broken)), "not refused");
}

TEST_F(ReadMeshTest, AGltfNamesItsFilesByUri) {
  std::string corners(36, '\0');
  for (const std::size_t at : {12u, 28u}) corners.replace(at, 4, "\0\0\x80\x3f", 4);
  for (const auto& [name, uri] :
       {std::pair("my pärt.bin", "my%20p%C3%A4rt.bin"), {"50%25.bin", "50%25.bin"}, {"a%2", "a%2"}}) {
    (void)file(name, corners);
    EXPECT_THAT(readMesh(file("a.gltf", gltf("", uri)), "the test", never).upper, ElementsAre(1, 1, 0)) << uri;
  }
}

// What had a hole where the face was became an open mesh without a word.
TEST_F(ReadMeshTest, AGltfWhoseFaceNamesNoVertexIsRefused) {
  const auto indexed = [](const char* indices) {  // Three vertices, two triangles.
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                   {"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}],
      "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":1,"byteLength":6}],
      "buffers":[{"byteLength":36,"uri":")" +
           std::string(kTriangleInside) + R"("},{"byteLength":6,"uri":"data:application/octet-stream;base64,)" +
           indices + "\"}]}";
  };
  EXPECT_EQ(readMesh(file("a.gltf", indexed("AAECAAIB")), "the test", never).triangles.size(), 2u);
  EXPECT_EQ(refusal(file("a.gltf", indexed("AAECAAID"))), "has a face whose vertex is not there");
}

}  // namespace
}  // namespace hapticd_mesh_file
