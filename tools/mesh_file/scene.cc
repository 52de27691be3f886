#include "tools/mesh_file/scene.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <new>
#include <pugixml.hpp>
#include <system_error>
#include <unordered_map>
#include <vector>

#include "tools/mesh_file/assimp/collada.h"
#include "tools/mesh_file/assimp/deformed.h"
#include "tools/mesh_file/assimp/dxf.h"
#include "tools/mesh_file/assimp/gltf.h"
#include "tools/mesh_file/assimp/three_mf.h"
#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/off.h"
#include "tools/mesh_file/own/ply.h"
#include "tools/mesh_file/own/stl.h"
#include "tools/mesh_file/own/words.h"
#include "tools/mesh_file/own/x3d.h"
#include "tools/mesh_file/polygon.h"
#include "tools/mesh_file/polygons.h"

namespace hapticd_mesh_file {
namespace {

struct PositionHash {
  std::size_t operator()(const std::array<float, 3>& p) const noexcept {
    std::uint64_t h = 0x9e3779b97f4a7c15u;
    for (const float c : p) h = (h ^ std::bit_cast<std::uint32_t>(c)) * 0xff51afd7ed558ccdu, h ^= h >> 32;
    return h;
  }
};

/** A mesh of assimp's, in its place. */
Polygons polygonsOf(const aiMesh& mesh, const Places& places) {
  Polygons out;
  out.vertices.reserve(places.vertices.size());
  for (const aiVector3D& v : places.vertices) out.vertices.push_back({v.x, v.y, v.z});
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    out.corners.insert(out.corners.end(), face.mIndices, face.mIndices + face.mNumIndices);
    out.sizes.push_back(face.mNumIndices);
    if (places.mirrored) std::reverse(out.corners.end() - face.mNumIndices, out.corners.end());
  }
  return out;
}

/** Makes one mesh of all that is added. */
class Gatherer {
 public:
  explicit Gatherer(MeshFile& out) : out_(out) {}

  /**
   * What the nodes of a scene hold, each in its place; `deforms`: which its morph targets and joints change. Else
   * what they would change is refused.
   */
  void node(const aiScene& scene, const aiNode& node, bool deforms, const aiMatrix4x4& parent = {}, int depth = 0) {
    if (depth > 512) throw MeshError("its nodes are nested more than 512 deep");
    const aiMatrix4x4 world = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
      if (!deforms) requireAtRest(scene, mesh, world);
      add(polygonsOf(mesh, deforms ? deformed(scene, mesh, world) : placedBy(mesh, world)));
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) this->node(scene, *node.mChildren[i], deforms, world, depth + 1);
  }

  void add(const Polygons& mesh) {
    std::vector<std::uint32_t> joined(mesh.vertices.size(), kUnused);
    bool used = false;
    const unsigned* corner = mesh.corners.data();
    for (std::size_t f = 0; f < mesh.sizes.size(); corner += mesh.sizes[f++]) {
      const unsigned size = mesh.sizes[f];
      if (size < 3) {
        ++out_.skipped;
        continue;
      }
      const char* const kind = size == 3 ? "triangle" : "face";
      for (unsigned c = 0; c < size; ++c) {
        const unsigned index = corner[c];
        if (index >= mesh.vertices.size())
          throw MeshError(fmt::format("{} {} names vertex {} of {}", kind, f, index, mesh.vertices.size()));
        if (joined[index] == kUnused) joined[index] = vertex(mesh.vertices[index], kind, f);
      }
      if (size == 3) {
        out_.triangles.push_back({joined[corner[0]], joined[corner[1]], joined[corner[2]]});
      } else {
        std::vector<std::array<float, 3>> places;
        for (unsigned c = 0; c < size; ++c) places.push_back(mesh.vertices[corner[c]]);
        for (const auto& t : trianglesOf(places))
          out_.triangles.push_back({joined[corner[t[0]]], joined[corner[t[1]]], joined[corner[t[2]]]});
      }
      used = true;
    }
    if (used) ++out_.meshes;
  }

 private:
  std::uint32_t vertex(std::array<float, 3> p, const char* kind, std::size_t face) {
    for (float& x : p) x += 0.0f;  // Makes -0 equal to 0.
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
      throw MeshError(fmt::format("{} {} has a vertex at {}, {}, {}", kind, face, p[0], p[1], p[2]),
                      "every coordinate must be a finite number; repair the file and load it again", kBadMesh);
    }
    const auto [place, fresh] = index_.try_emplace(p, static_cast<std::uint32_t>(out_.vertices.size()));
    if (fresh) out_.vertices.push_back(p);
    return place->second;
  }

  static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  MeshFile& out_;
  std::unordered_map<std::array<float, 3>, std::uint32_t, PositionHash> index_;
};

/** With a digit before each point that has none. */
std::string withDigits(std::string_view numbers) {
  std::string out;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] == '.' && (i == 0 || numbers[i - 1] == ' ' || numbers[i - 1] == '\t')) out += '0';
    out += numbers[i];
  }
  return out;
}

/**
 * An OBJ whose lines begin with blanks or end with comments, or that begins with a byte order mark: assimp leaves out
 * the first in silence, and takes the others for corners that are none. It counts ".5" as no coordinate. Without all
 * that; empty for all other files. Throws MeshError if the last line is a face that lacks corners, of which assimp
 * makes a line.
 */
std::string plainObj(const std::string& path) {
  constexpr std::string_view kBlanks = " \t";
  if (!endsWith(path, ".obj") || !std::filesystem::is_regular_file(path)) return {};
  std::ifstream file(path, std::ios::binary);
  std::string out, last;
  bool other = false, goes_on = false;
  for (std::string text; std::getline(file, text); out += '\n') {
    std::string_view line = text;
    if (out.empty()) line = withoutMark(line);
    const std::size_t first = line.find_first_not_of(kBlanks), comment = line.find('#');
    if (!goes_on) line.remove_prefix(std::min(first, line.size()));
    if (comment != line.npos && comment > first) line = line.substr(0, line.find('#'));
    if (!goes_on && line.find_first_not_of(" \t\r") != line.npos) last.clear();
    if (goes_on || last.empty()) last += line;
    const std::string digits = last.starts_with('v') ? withDigits(line) : std::string();
    if (digits.size() > line.size()) line = digits;
    goes_on = !line.empty() && line.substr(0, line.find_last_not_of('\r') + 1).ends_with('\\');
    other = other || line != text;
    out += line;
  }
  std::string_view face = last;
  if (takeWord(face) == "f") {
    int corners = 0;
    for (std::string_view word = takeWord(face); !word.empty(); word = takeWord(face)) corners += word == "\\" ? 0 : 1;
    if (corners < 3) refuse(fmt::format("is cut short: its last face has {} corners", corners));
  }
  return other ? out : std::string();
}

/** A file may name another by a URI, in which blanks and umlauts are coded; assimp looks for the code. */
class NamedByUri : public Assimp::DefaultIOSystem {
 public:
  bool Exists(const char* name) const override {
    return DefaultIOSystem::Exists(name) || DefaultIOSystem::Exists(percentDecoded(name).c_str());
  }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    return DefaultIOSystem::Open(DefaultIOSystem::Exists(name) ? name : percentDecoded(name).c_str(), mode);
  }
};

/** What stands beside a file by that name. */
std::string besides(const std::string& path, const std::string& name) {
  const auto file = std::filesystem::path(path).parent_path() / percentDecoded(name);
  std::error_code no_name;  // What is too long for one, say.
  return std::filesystem::is_regular_file(file, no_name) ? bytesOf(file.string()) : std::string();
}

/** Of an AMF that turns its parts: assimp (5.2) takes the degrees about an axis for where a part stands along it. */
void requireNotTurned(const std::string& path) {
  const std::string bytes = bytesOf(path);
  pugi::xml_document file;
  if (!file.load_buffer(bytes.data(), bytes.size())) return;  // assimp says why, or it is packed.
  const auto isZero = [](const pugi::xml_node& instance, const char* name) {
    std::string_view text = instance.child_value(name);
    return numberIn(takeWord(text)).value_or(0) == 0;
  };
  constexpr const char* kAxes[][2] = {{"rx", "deltax"}, {"ry", "deltay"}, {"rz", "deltaz"}};
  for (const auto& constellation : file.child("amf").children("constellation")) {
    for (const auto& instance : constellation.children("instance")) {
      for (const auto& [turn, shift] : kAxes) {
        if (!instance.child(turn) || (isZero(instance, turn) && isZero(instance, shift))) continue;
        throw MeshError(fmt::format("turns its parts ({}), which is not read", turn),
                        "export them where they stand, or as another format", kBadMesh);
      }
    }
  }
}

/**
 * That the ending of a file's name says the format in which assimp has read it: it looks for others as well where that
 * does not fit or has several. Endings tell here what is asked of a file before.
 */
void requireNamedSo(const std::string& path, const Assimp::Importer& importer) {
  const aiImporterDesc* const read = importer.GetImporterInfo(importer.GetPropertyInteger("importerIndex"));
  std::string_view endings = read != nullptr ? read->mFileExtensions : "", first;
  for (std::string_view ending = takeWord(endings); !ending.empty(); ending = takeWord(endings)) {
    if (endsWith(path, fmt::format(".{}", ending))) return;
    if (first.empty()) first = ending;
  }
  throw MeshError("holds another format than the ending of its name says",
                  fmt::format("end its name with .{}, by which it is checked and read", first), kBadMesh);
}

/** What assimp makes of a file. */
void addScene(const std::string& path, std::string_view program, Gatherer& gatherer) {
  Assimp::Importer importer;
  importer.SetIOHandler(new NamedByUri);  // Owned from now on.
  const bool deforms = isGltf(path);
  int not_felt = aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                 aiComponent_TEXCOORDS | aiComponent_ANIMATIONS | aiComponent_TEXTURES | aiComponent_LIGHTS |
                 aiComponent_CAMERAS;
  if (!deforms && !endsWith(path, ".dae") && !endsWith(path, ".fbx")) not_felt |= aiComponent_BONEWEIGHTS;
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, not_felt);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);  // It would draw bones where no mesh is.
  const aiScene* scene = nullptr;
  std::string error;
  const std::string remedy = fmt::format(
      "is it whole, and does the ending of its name fit? {} reads STL, OBJ, PLY, X3D, 3DS, glTF and the "
      "other formats of assimp",
      program);
  if (deforms) requirePlainGltf(bytesOf(path));
  // By such a name assimp would look for a format that it takes for itself, past what is asked of that here.
  if (!importer.IsExtensionSupported(std::filesystem::path(path).extension().string()))
    throw MeshError("has a name whose ending says no format", remedy);
  if (endsWith(path, ".amf")) requireNotTurned(path);
  if (endsWith(path, ".dae") || endsWith(path, ".zae") || endsWith(path, ".xml")) requirePlainCollada(bytesOf(path));
  if (endsWith(path, ".dxf")) requirePlainInserts(bytesOf(path));
  if (endsWith(path, ".3mf")) requireModelsOnly(bytesOf(path));
  const LostFaces lost;
  const std::string obj = plainObj(path);
  try {
    // Polygons are cut here, not by assimp: where three corners of one lie in a line it lays a lid over its hollow.
    scene = obj.empty() ? importer.ReadFile(path, aiProcess_RemoveComponent)
                        : importer.ReadFileFromMemory(obj.data(), obj.size(), aiProcess_RemoveComponent, "obj");
    error = importer.GetErrorString();
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (scene == nullptr || scene->mRootNode == nullptr) {
    if (error.find("bad_alloc") != error.npos) throw std::bad_alloc();  // As assimp hands it on, or what() has it.
    throw MeshError(error.empty() ? "holds no scene" : error, remedy);
  }
  requireNamedSo(path, importer);
  if (lost.any()) refuse("has a face whose vertex is not there");
  gatherer.node(*scene, *scene->mRootNode, deforms);
}

/** Coordinates are floats, in most files and here: far from the origin they come in steps that a hand would feel. */
void requireFine(const MeshFile& mesh) {
  constexpr double kFeltStep = 5e-4;  // Of the longest side: 0.05 mm of 100.
  double longest = 0;
  float farthest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    longest = std::max(longest, mesh.upper[i] - mesh.lower[i]);
    farthest = std::max({farthest, static_cast<float>(mesh.upper[i]), static_cast<float>(-mesh.lower[i])});
  }
  const double step = std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest;
  if (longest == 0 || step <= kFeltStep * longest) return;  // That it is but a point is told with its scale.
  throw MeshError(fmt::format("is {:.3g} long and lies {:.3g} from the origin, where its coordinates come in steps of "
                              "{:.2g}",
                              longest, farthest, step),
                  "move it to the origin in the program that made it, and export it again", kBadMesh);
}

}  // namespace

MeshFile readScene(const std::string& path, std::string_view program) {
  MeshFile out;
  Gatherer gatherer(out);
  if (isPly(path)) {
    gatherer.add(parsePly(bytesOf(path)));
  } else if (endsWith(path, ".stl")) {
    gatherer.add(parseStl(bytesOf(path)));
  } else if (isOff(path)) {
    gatherer.add(parseOff(bytesOf(path)));
  } else if (isX3d(path)) {
    for (const Polygons& shape : parseX3d(bytesOf(path), [&](const std::string& name) { return besides(path, name); }))
      gatherer.add(shape);
  } else if (endsWith(path, ".wrl") || endsWith(path, ".vrml") || endsWith(path, ".x3dv")) {
    throw MeshError("is VRML, or X3D not written in XML, neither of which is read",
                    "convert it to X3D in XML (.x3d), OBJ or PLY", kBadMesh);
  } else {
    addScene(path, program, gatherer);
  }
  if (out.triangles.empty()) {
    throw MeshError(
        out.skipped > 0 ? fmt::format("holds {} points or lines but no triangle", out.skipped) : "holds no triangle",
        endsWith(path, ".3mf")
            ? "meshes in further files within it (production extension) are not read; export it as STL"
            : "a surface is needed to touch; export the mesh with its faces",
        kBadMesh);
  }
  measure(out);
  requireFine(out);
  return out;
}

}  // namespace hapticd_mesh_file
