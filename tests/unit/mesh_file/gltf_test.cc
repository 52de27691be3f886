// glTF: what assimp passes over in it.
#include "tools/mesh_file/assimp/gltf.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string_view>
#include <vector>

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

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63u];
  }
  return out;
}

/** A file of accessors, each with floats of its own. */
class Accessors {
 public:
  void add(const char* type, std::size_t count, const std::vector<float>& values) {
    const std::size_t bytes = 4 * values.size();
    accessors_ += fmt::format(R"({}{{"bufferView":{},"componentType":5126,"count":{},"type":"{}"}})", comma(), views_,
                              count, type);
    buffer_views_ += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})", comma(), buffer_.size(), bytes);
    buffer_.append(reinterpret_cast<const char*>(values.data()), bytes);
    ++views_;
  }
  /** `what`: its scenes, nodes and meshes. */
  [[nodiscard]] std::string file(const std::string& what) const {
    return fmt::format(R"({{"asset":{{"version":"2.0"}},"scene":0,{},"accessors":[{}],"bufferViews":[{}],)"
                       R"("buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}]}})",
                       what, accessors_, buffer_views_, buffer_.size(), base64(buffer_));
  }

 private:
  [[nodiscard]] const char* comma() const { return views_ == 0 ? "" : ","; }
  std::string accessors_, buffer_views_, buffer_;
  int views_ = 0;
};

// A face whose smile is a morph target was felt without it.
TEST_F(ReadMeshTest, AGltfIsMorphedByItsDefaultWeights) {
  Accessors numbers;
  numbers.add("VEC3", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0});
  numbers.add("VEC3", 3, {0, 0, 0, 3, 0, 0, 0, 0, 0});  // What is added to each.
  numbers.add("VEC3", 3, {0, 0, 8, 0, 0, 0, 0, 4, 0});
  const auto morphed = [&](const char* node, const char* mesh) {
    return numbers.file(fmt::format(R"("scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"scale":[1,1,10]{}}}],)"
                                    R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},)"
                                    R"("targets":[{{"POSITION":1}},{{"POSITION":2}}]}}]{}}}])",
                                    node, mesh));
  };
  const auto read = [&](const std::string& text) { return readMesh(file("a.gltf", text), "the test", never).upper; };
  EXPECT_THAT(read(morphed("", "")), ElementsAre(1, 1, 0)) << "without weights they are zero";
  EXPECT_THAT(read(morphed("", R"(,"weights":[0.5,0.25])")), ElementsAre(2.5, 2, 20));
  EXPECT_THAT(read(morphed(R"(,"weights":[0.5,0])", R"(,"weights":[0.5,0])")), ElementsAre(2.5, 1, 0));
  EXPECT_THAT(read(morphed(R"(,"weights":[0,0])", "")), ElementsAre(1, 1, 0));
  EXPECT_THAT(refusal(file("a.gltf", morphed(R"(,"weights":[1,0])", R"(,"weights":[0.5,0])"))),
              HasSubstr("a node that morphs its mesh otherwise"));
  EXPECT_THAT(refusal(file("a.gltf", morphed(R"(,"weights":[1,0])", ""))), HasSubstr("otherwise than the mesh"));
}

// One that is bound to joints was felt where its node is, which glTF has everybody leave out of it.
TEST_F(ReadMeshTest, AGltfWithASkinIsWhereItsJointsAre) {
  Accessors numbers;
  numbers.add("VEC3", 3, {5, 0, 0, 6, 0, 0, 5, 1, 0});
  numbers.add("VEC4", 3, {1, 0, 0, 0, 0.5, 0.5, 0, 0, 0, 1, 0, 0});                                 // Weights.
  numbers.add("MAT4", 2, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -5, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0,  // 5 to the left,
                          0, 0, 1, 0, 0, 0, 0, 1});                                                 // and none.
  std::string joints(24, '\0');  // Of each vertex the first two, as 16 bits.
  for (const std::size_t v : {0u, 1u, 2u}) joints[8 * v + 2] = 1;
  const auto skinned = [&](const char* second) {
    std::string text = numbers.file(fmt::format(
        R"("scenes":[{{"nodes":[0,1]}}],"skins":[{{"joints":[2,3],"inverseBindMatrices":2}}],)"
        R"("nodes":[{{"mesh":0,"skin":0,"translation":[100,0,0]}},{{"name":"arm","children":[2,3],"scale":[2,2,2]}},)"
        R"({{"name":"upper","translation":[7,0,0]}},{{"name":"{}","translation":[0,0,20]}}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"WEIGHTS_0":1,"JOINTS_0":3}}}}]}}])",
        second));
    const auto add = [&text](const char* list, const std::string& more) {
      text.insert(text.find(']', text.rfind(list)), "," + more);
    };
    add("\"accessors\":", R"({"bufferView":3,"componentType":5123,"count":3,"type":"VEC4"})");
    add("\"bufferViews\":", R"({"buffer":1,"byteLength":24})");
    add("\"buffers\":", R"({"byteLength":24,"uri":"data:application/octet-stream;base64,)" + base64(joints) + "\"}");
    return text;
  };
  const MeshFile mesh = readMesh(file("a.gltf", skinned("lower")), "the test", never);
  // The first goes with the upper arm to 2 (5 - 5 + 7), the last with the lower one, the second half with each.
  EXPECT_THAT(mesh.vertices, ElementsAre(ElementsAre(14, 0, 0), ElementsAre(14, 0, 20), ElementsAre(10, 2, 40)));
  EXPECT_EQ(refusal(file("a.gltf", skinned("arm"))), "has a skin with a joint 'arm', and 2 nodes of that name");
}

// It was felt.
TEST_F(ReadMeshTest, AGltfThatHidesANodeIsRefused) {
  Accessors numbers;
  numbers.add("VEC3", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const auto second = [&](const std::string& with) {
    return file("a.gltf", numbers.file(R"("extensionsUsed":["KHR_node_visibility"],"scenes":[{"nodes":[0,1]}],)"
                                       R"("nodes":[{"mesh":0},{"mesh":0,"translation":[9,0,0])" +
                                       with + R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])"));
  };
  const std::string hidden = R"(,"extensions":{"KHR_node_visibility":{"visible":false}})";
  EXPECT_EQ(refusal(second(hidden)), "hides a node (KHR_node_visibility), which would be felt");
  EXPECT_EQ(refusal(second(R"(,"name":"lid")" + hidden)),
            "hides a node 'lid' (KHR_node_visibility), which would be felt");
  for (const char* const shown :
       {"", R"(,"extensions":{"KHR_node_visibility":{"visible":true}})", R"(,"extensions":{"KHR_node_visibility":{}})"})
    EXPECT_EQ(refusal(second(shown)), "not refused") << shown;
}

}  // namespace
}  // namespace hapticd_mesh_file
