#include "tools/mesh_file/scene.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/ply.h"
#include "tools/mesh_file/polygon.h"
#include "tools/mesh_file/stl.h"

namespace hapticd_mesh_file {
namespace {

struct PositionHash {
  std::size_t operator()(const std::array<float, 3>& p) const noexcept {
    std::uint64_t h = 0x9e3779b97f4a7c15u;
    for (const float c : p) h = (h ^ std::bit_cast<std::uint32_t>(c)) * 0xff51afd7ed558ccdu, h ^= h >> 32;
    return h;
  }
};

/** Walks the nodes of a scene and gathers their triangles. */
class Gatherer {
 public:
  Gatherer(const aiScene& scene, MeshFile& out) : scene_(scene), out_(out) {}

  void node(const aiNode& node, const aiMatrix4x4& parent, int depth) {
    if (depth > 512) throw MeshError("its nodes are nested more than 512 deep");
    const aiMatrix4x4 world = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) mesh(*scene_.mMeshes[node.mMeshes[i]], world);
    for (unsigned i = 0; i < node.mNumChildren; ++i) this->node(*node.mChildren[i], world, depth + 1);
  }

 private:
  void mesh(const aiMesh& mesh, const aiMatrix4x4& world) {
    // A mirroring transform turns triangles inside out; turn them back.
    const bool mirrored = world.Determinant() < 0;
    std::vector<std::uint32_t> joined(mesh.mNumVertices, kUnused);
    bool used = false;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) {
        ++out_.skipped;
        continue;
      }
      const char* const kind = face.mNumIndices == 3 ? "triangle" : "face";
      for (unsigned c = 0; c < face.mNumIndices; ++c) {
        const unsigned index = face.mIndices[c];
        if (index >= mesh.mNumVertices)
          throw MeshError(fmt::format("{} {} names vertex {} of {}", kind, f, index, mesh.mNumVertices));
        if (joined[index] == kUnused) joined[index] = vertex(world * mesh.mVertices[index], kind, f);
      }
      const auto add = [&](const std::array<std::uint32_t, 3>& of_face) {
        std::array<std::uint32_t, 3> corners{};
        for (unsigned c = 0; c < 3; ++c) corners[mirrored ? 2 - c : c] = joined[face.mIndices[of_face[c]]];
        out_.triangles.push_back(corners);
      };
      if (face.mNumIndices == 3) {
        add({0, 1, 2});
      } else {
        std::vector<std::array<float, 3>> places;
        for (unsigned c = 0; c < face.mNumIndices; ++c) {
          const aiVector3D& v = mesh.mVertices[face.mIndices[c]];
          places.push_back({v.x, v.y, v.z});
        }
        for (const auto& triangle : trianglesOf(places)) add(triangle);
      }
      used = true;
    }
    if (used) ++out_.meshes;
  }

  std::uint32_t vertex(const aiVector3D& v, const char* kind, unsigned face) {
    // Adding zero makes -0 equal to 0.
    const std::array<float, 3> p{v.x + 0.0f, v.y + 0.0f, v.z + 0.0f};
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      throw MeshError(fmt::format("{} {} has a vertex at {}, {}, {}", kind, face, p[0], p[1], p[2]),
                      "every coordinate must be a finite number; repair the file and load it again", kBadMesh);
    }
    const auto [place, fresh] = index_.try_emplace(p, static_cast<std::uint32_t>(out_.vertices.size()));
    if (fresh) out_.vertices.push_back(p);
    return place->second;
  }

  static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  const aiScene& scene_;
  MeshFile& out_;
  std::unordered_map<std::array<float, 3>, std::uint32_t, PositionHash> index_;
};

/**
 * An OBJ whose lines begin with blanks or end with comments, or that begins with a byte order mark: assimp leaves out
 * the first in silence, and takes the others for corners that are none. Without all that; empty for all other files.
 */
std::string plainObj(const std::string& path) {
  constexpr std::string_view kMark = "\xef\xbb\xbf", kBlanks = " \t";
  std::string ending = path.substr(path.size() - std::min<std::size_t>(4, path.size()));
  for (char& c : ending) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  if (ending != ".obj" || !std::filesystem::is_regular_file(path)) return {};
  std::ifstream file(path, std::ios::binary);
  std::string out;
  bool other = false, goes_on = false;
  for (std::string text; std::getline(file, text); out += '\n') {
    std::string_view line = text;
    if (out.empty() && line.substr(0, kMark.size()) == kMark) line.remove_prefix(kMark.size());
    const std::size_t first = line.find_first_not_of(kBlanks), comment = line.find('#');
    if (!goes_on) line.remove_prefix(std::min(first, line.size()));
    if (comment != line.npos && comment > first) line = line.substr(0, line.find('#'));
    other = other || line.size() != text.size();
    goes_on = !line.empty() && line.substr(0, line.find_last_not_of('\r') + 1).ends_with('\\');
    out += line;
  }
  return other ? out : std::string();
}

/** While it lives: what assimp's OFF reader says of faces that it leaves out, or gives other corners, and then takes.
 */
class OffComplaint {
 public:
  OffComplaint() {
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0);
    Assimp::DefaultLogger::get()->attachStream(new Stream(first_), Assimp::Logger::Err);  // Which it will own.
  }
  OffComplaint(const OffComplaint&) = delete;
  OffComplaint& operator=(const OffComplaint&) = delete;
  ~OffComplaint() { Assimp::DefaultLogger::kill(); }
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  class Stream : public Assimp::LogStream {
   public:
    explicit Stream(std::string& first) : first_(first) {}
    void write(const char* message) override {
      const std::string_view text = message;
      const std::size_t at = text.find("OFF: ");
      if (first_.empty() && at != text.npos) first_ = text.substr(at, text.find('\n', at) - at);
    }

   private:
    std::string& first_;
  };

  std::string first_;
};

}  // namespace

MeshFile readScene(const std::string& path, std::string_view program) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
  const aiScene* scene = nullptr;
  std::unique_ptr<aiScene> ply;
  std::string error;
  const OffComplaint off;
  try {
    // Polygons are cut here, not by assimp: where three corners of one lie in a line it lays a lid over its hollow.
    if (isPly(path)) {
      ply = readPly(path);
      scene = ply.get();
    } else {
      const std::string obj = plainObj(path);
      scene = obj.empty() ? importer.ReadFile(path, aiProcess_RemoveComponent)
                          : importer.ReadFileFromMemory(obj.data(), obj.size(), aiProcess_RemoveComponent, "obj");
      error = importer.GetErrorString();
    }
  } catch (const MeshError&) {
    throw;
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (const std::string ending = path.substr(path.size() - std::min<std::size_t>(4, path.size()));
      (ending == ".stl" || ending == ".STL") && endsInAFacet(path))
    throw MeshError("is cut short: its last facet has no end", "export it again", kBadMesh);
  if (error.find("STL storage representation") != error.npos)
    throw MeshError(whyNoStl(path), "it is damaged or cut short: export it again", kBadMesh);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    if (error.find("bad_alloc") != error.npos)  // As assimp hands it on, or what() has it.
      throw MeshError("is too large for this machine's memory, or damaged", "make it coarser", kBadMesh);
    throw MeshError(error.empty() ? "holds no scene" : error,
                    "is it whole, and does the ending of its name fit? " +
                        fmt::format("{} reads STL, OBJ, PLY, 3DS, glTF and the other formats of assimp", program));
  }
  if (!off.first().empty()) {
    throw MeshError(off.first(), "it is damaged, or has faces of more than nine corners: export it as triangles or PLY",
                    kBadMesh);
  }
  MeshFile out;
  Gatherer(*scene, out).node(*scene->mRootNode, aiMatrix4x4(), 0);
  if (out.triangles.empty()) {
    throw MeshError(
        out.skipped > 0 ? fmt::format("holds {} points or lines but no triangle", out.skipped) : "holds no triangle",
        "a surface is needed to touch; export the mesh with its faces", kBadMesh);
  }
  measure(out);
  return out;
}

}  // namespace hapticd_mesh_file
