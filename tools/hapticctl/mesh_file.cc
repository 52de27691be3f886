#include "tools/hapticctl/mesh_file.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <unordered_map>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/mesh_child.h"
#include "tools/hapticctl/numbers.h"

namespace hapticctl {
namespace {

struct Unit {
  const char* name;
  double metres;
};
constexpr Unit kUnits[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"inch", 0.0254}, {"um", 1e-6}, {"ft", 0.3048}};
constexpr std::size_t kAdvised = 4;  // Those that mesh files are usually in.

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
    if (depth > 512) throw Failure{kExitFile, out_.path, "its nodes are nested more than 512 deep", {}};
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
      if (face.mNumIndices != 3) {
        ++out_.skipped;
        continue;
      }
      std::array<std::uint32_t, 3> corners{};
      for (unsigned c = 0; c < 3; ++c) {
        const unsigned index = face.mIndices[c];
        if (index >= mesh.mNumVertices) {
          throw Failure{
              kExitFile, out_.path, fmt::format("triangle {} names vertex {} of {}", f, index, mesh.mNumVertices), {}};
        }
        if (joined[index] == kUnused) joined[index] = vertex(world * mesh.mVertices[index], f);
        corners[mirrored ? 2 - c : c] = joined[index];
      }
      out_.triangles.push_back(corners);
      used = true;
    }
    if (used) ++out_.meshes;
  }

  std::uint32_t vertex(const aiVector3D& v, unsigned triangle) {
    // Adding zero makes -0 equal to 0.
    const std::array<float, 3> p{v.x + 0.0f, v.y + 0.0f, v.z + 0.0f};
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      throw Failure{kExitFile, out_.path,
                    fmt::format("triangle {} has a vertex at {}, {}, {}", triangle, p[0], p[1], p[2]),
                    "every coordinate must be a finite number; repair the file and load it again", "BAD_MESH"};
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

void measure(MeshFile& mesh) {
  mesh.lower.fill(std::numeric_limits<double>::infinity());
  mesh.upper.fill(-std::numeric_limits<double>::infinity());
  for (const auto& v : mesh.vertices) {
    for (std::size_t i = 0; i < 3; ++i) {
      mesh.lower[i] = std::min<double>(mesh.lower[i], v[i]);
      mesh.upper[i] = std::max<double>(mesh.upper[i], v[i]);
    }
  }
}

void checkReadable(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error && error != std::errc::no_such_file_or_directory) throw Failure{kExitFile, path, error.message(), {}};
  if (!std::filesystem::exists(status)) throw Failure{kExitFile, path, "no such file", {}};
  if (std::filesystem::is_directory(status)) throw Failure{kExitFile, path, "is a directory, not a mesh file", {}};
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(path, error) == 0) {
    throw Failure{kExitFile, path, "is empty", {}};
  }
  std::FILE* file = std::fopen(path.c_str(), "rbe");
  if (file == nullptr) throw Failure{kExitFile, path, std::generic_category().message(errno), {}};
  std::fclose(file);
}

MeshFile parse(const std::string& path) {
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
  const aiScene* scene = nullptr;
  std::string error;
  try {
    scene = importer.ReadFile(path, aiProcess_Triangulate | aiProcess_RemoveComponent);
    error = importer.GetErrorString();
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw Failure{
        kExitFile, path, error.empty() ? "holds no scene" : error,
        "hapticctl reads STL, OBJ, PLY, 3DS, glTF and the other formats of assimp; the ending of the name must fit"};
  }
  MeshFile out;
  out.path = path;
  Gatherer(*scene, out).node(*scene->mRootNode, aiMatrix4x4(), 0);
  if (out.triangles.empty()) {
    throw Failure{
        kExitFile, path,
        out.skipped > 0 ? fmt::format("holds {} points or lines but no triangle", out.skipped) : "holds no triangle",
        "a surface is needed to touch; export the mesh with its faces", "BAD_MESH"};
  }
  measure(out);
  return out;
}

}  // namespace

MeshFile readMesh(const std::string& path) {
  checkReadable(path);
  return readInChild(path, [&] { return parse(path); });  // A PLY file that is cut short is read beyond its end.
}

double parseScale(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (text == unit.name || (text == "in" && unit.metres == 0.0254)) return unit.metres;
  }
  const auto value = parseNumber(text);
  if (!value || !(*value > 0)) {
    failUsage("--scale", fmt::format("'{}' is neither a unit nor a positive number", text),
              "write the file's unit (mm, cm, m, inch, um, ft) or metres per file unit (0.001)");
  }
  return *value;
}

std::string scaleAdvice(const MeshFile& mesh) {
  std::array<double, 3> side{};
  for (std::size_t i = 0; i < 3; ++i) side[i] = mesh.upper[i] - mesh.lower[i];
  std::string text = fmt::format("its box is {:.6g} x {:.6g} x {:.6g} file units, from ({:.6g}, {:.6g}, {:.6g})\n",
                                 side[0], side[1], side[2], mesh.lower[0], mesh.lower[1], mesh.lower[2]);
  for (std::size_t u = 0; u < kAdvised; ++u) {
    text +=
        fmt::format("--scale {:<7} would make it {} x {} x {}\n", kUnits[u].name, length(side[0] * kUnits[u].metres),
                    length(side[1] * kUnits[u].metres), length(side[2] * kUnits[u].metres));
  }
  text += "--scale NUMBER  metres per file unit;  --size METRES  makes the longest side that long";
  if (mesh.path.ends_with(".gltf") || mesh.path.ends_with(".glb"))
    text += "\nglTF is in metres by its standard: --scale m";
  return text;
}

void centre(MeshFile& mesh) {
  for (auto& v : mesh.vertices) {
    for (std::size_t i = 0; i < 3; ++i) v[i] = static_cast<float>(v[i] - 0.5 * (mesh.lower[i] + mesh.upper[i]));
  }
  measure(mesh);
}

void scale(MeshFile& mesh, double metres_per_unit) {
  MeshFile before;
  before.path = mesh.path;
  before.lower = mesh.lower;
  before.upper = mesh.upper;
  for (auto& v : mesh.vertices) {
    for (float& c : v) c = static_cast<float>(c * metres_per_unit);
  }
  measure(mesh);
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, mesh.upper[i] - mesh.lower[i]);
  constexpr double kLeast_m = 1e-6, kMost_m = 200;  // No hand feels less; the daemon takes coordinates to 100 m.
  if (!(longest >= kLeast_m && longest <= kMost_m)) {
    failUsage("--scale",
              fmt::format("{} metres per unit make the longest side of {} {:.3g} m: from {:g} to {:g} m it can be",
                          metres_per_unit, mesh.path, longest, kLeast_m, kMost_m),
              scaleAdvice(before));
  }
}

}  // namespace hapticctl
