#include "tools/mesh_file/assimp/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/LogStream.hpp>
#include <charconv>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

/** Required extensions that are read, or that are seen and not felt; how their names begin. */
constexpr std::string_view kKnown[] = {"KHR_draco_mesh_compression",
                                       "KHR_materials_",
                                       "KHR_texture_",
                                       "KHR_lights_",
                                       "KHR_animation_",
                                       "EXT_texture_",
                                       "EXT_lights_",
                                       "MSFT_texture_",
                                       "MSFT_packing_"};

std::uint64_t littleEndian(std::string_view bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint64_t{static_cast<unsigned char>(bytes[at + i])} << 8 * i;
  return value;
}

/** The description in words; of a binary file its first part. */
std::string_view jsonOf(std::string_view bytes) {
  constexpr std::size_t kBeforeJson = 20;
  if (bytes.substr(0, 4) != "glTF") return withoutMark(bytes);
  if (bytes.size() < kBeforeJson || bytes.substr(16, 4) != "JSON") return {};
  return bytes.substr(kBeforeJson, littleEndian(bytes, 12));
}

[[noreturn]] void refuseExtension(const std::string& name) {
  throw MeshError(fmt::format("needs the extension {}, which is not read", shown(name, 60)),
                  "export it without: neither quantized nor compressed with meshopt nor instanced", kBadMesh);
}

/** assimp reads a mesh's weights, and not those that a node gives its mesh in their place. */
void requireWeightsOfMeshes(const nlohmann::json& file) {
  using Json = nlohmann::json;
  const auto list = [](const Json& object, const char* name) {
    const auto found = object.is_object() ? object.find(name) : object.end();
    return object.is_object() && found != object.end() && found->is_array() ? *found : Json::array();
  };
  const Json meshes = list(file, "meshes");
  for (const Json& node : list(file, "nodes")) {
    const Json weights = list(node, "weights");
    const auto index = node.is_object() ? node.find("mesh") : node.end();
    if (weights.empty() || index == node.end() || !index->is_number_unsigned()) continue;
    Json own = index->get<std::size_t>() < meshes.size() ? list(meshes[index->get<std::size_t>()], "weights") : Json();
    while (own.size() < weights.size()) own.push_back(0);
    if (own == weights) continue;
    throw MeshError("has a node that morphs its mesh otherwise than the mesh says ('weights'), which is not read",
                    "apply its shape keys before the export", kBadMesh);
  }
}

/** assimp shows what a node hides, with all below it. */
void requireAllSeen(const nlohmann::json& file) {
  const nlohmann::json::json_pointer visible("/extensions/KHR_node_visibility/visible");
  if (!file.is_object() || !file.contains("nodes")) return;
  for (const nlohmann::json& node : file["nodes"]) {
    if (!node.contains(visible) || node[visible] != false) continue;
    const auto name = node.find("name");
    throw MeshError(
        fmt::format(
            "hides a node{} (KHR_node_visibility), which would be felt",
            name != node.end() && name->is_string() ? " '" + shown(name->get<std::string>(), 60) + "'" : std::string()),
        "delete what is hidden before the export", kBadMesh);
  }
}

class Listener : public Assimp::LogStream {
 public:
  explicit Listener(bool& lost) : lost_(lost) {}
  void write(const char* message) override {
    lost_ = lost_ || std::string_view(message).find("Those faces were dropped") != std::string_view::npos;
  }

 private:
  bool& lost_;
};

}  // namespace

LostFaces::LostFaces() {
  Assimp::DefaultLogger::create(nullptr, Assimp::Logger::NORMAL, 0)->attachStream(new Listener(any_));  // Owned.
}

LostFaces::~LostFaces() { Assimp::DefaultLogger::kill(); }

bool isGltf(const std::string& path) { return endsWith(path, ".gltf") || endsWith(path, ".glb"); }

void requirePlainGltf(std::string_view bytes) {
  using Json = nlohmann::json;
  const Json file = Json::parse(jsonOf(bytes), nullptr, false);
  const auto names = [&file](const char* list) {
    std::vector<std::string> out;
    const auto all = file.is_object() ? file.find(list) : file.end();
    if (!file.is_object() || all == file.end()) return out;
    for (const Json& name : *all)
      if (name.is_string()) out.push_back(name.get<std::string>());
    return out;
  };
  for (const std::string& name : names("extensionsRequired")) {
    const bool known = std::any_of(std::begin(kKnown), std::end(kKnown),
                                   [&name](std::string_view begin) { return name.starts_with(begin); });
    if (!known) refuseExtension(name);
  }
  // Who does not know it sees one instance, which is allowed, and would feel one.
  constexpr const char* kInstances = "EXT_mesh_gpu_instancing";
  for (const std::string& name : names("extensionsUsed"))
    if (name == kInstances) refuseExtension(name);
  requireWeightsOfMeshes(file);
  requireAllSeen(file);
}

std::string percentDecoded(std::string_view uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned code = 0;
    if (uri[i] == '%' && i + 2 < uri.size()) {
      const auto [end, problem] = std::from_chars(uri.data() + i + 1, uri.data() + i + 3, code, 16);
      if (problem == std::errc() && end == uri.data() + i + 3) {
        out += static_cast<char>(code);
        i += 2;
        continue;
      }
    }
    out += uri[i];
  }
  return out;
}

}  // namespace hapticd_mesh_file
