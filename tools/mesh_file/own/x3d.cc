#include "tools/mesh_file/own/x3d.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <iterator>
#include <map>
#include <pugixml.hpp>
#include <utility>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/round_shapes.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

using Node = pugi::xml_node;

constexpr std::string_view kBetween = " \t\r\n,";  // Of numbers.
/** What has children that are seen as they are, or moved. */
constexpr std::string_view kGroups[] = {
    "X3D",         "Scene", "Group",    "StaticGroup", "Transform",        "Anchor",  "Billboard",
    "Collision",   "LOD",   "Switch",   "CADLayer",    "CADAssembly",      "CADPart", "CADFace",
    "ToggleGroup", "Layer", "LayerSet", "Viewport",    "DynamicTransform", "Inline"};
/** What may hold shapes that are not the scene's. */
constexpr std::string_view kApart[] = {"head", "DeviceInfo", "ProtoDeclare", "ExternProtoDeclare"};
/** No surface. */
constexpr std::string_view kThin[] = {"IndexedLineSet", "LineSet",  "PointSet",   "Text",
                                      "Arc2D",          "Circle2D", "Polyline2D", "Polypoint2D"};

template <std::size_t n>
bool isOne(const std::string_view (&names)[n], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

[[noreturn]] void refuseKind(const std::string& what) {
  throw MeshError(what, "export it as an IndexedFaceSet, or as another format", kBadMesh);
}

/** What is told of a node. */
std::string named(const Node& node) { return fmt::format("'{}'", shown(node.name(), 40)); }

std::vector<double> numbersOf(const Node& node, const char* field) {
  std::vector<double> out;
  std::string_view rest = node.attribute(field).value();
  for (;;) {
    rest.remove_prefix(std::min(rest.find_first_not_of(kBetween), rest.size()));
    if (rest.empty()) return out;
    const std::string_view word = rest.substr(0, rest.find_first_of(kBetween));
    const auto value = numberIn(word);
    if (!value) refuse(fmt::format("{} of {}: '{}' is not a number", field, named(node), shown(word)));
    out.push_back(*value);
    rest.remove_prefix(word.size());
  }
}

/** So many numbers of a field, or those that it has where it is not given. */
template <std::size_t n>
std::array<double, n> valueOf(const Node& node, const char* field, const std::array<double, n>& without) {
  if (!node.attribute(field)) return without;
  const std::vector<double> numbers = numbersOf(node, field);
  std::array<double, n> out{};
  if (numbers.size() != n)
    refuse(fmt::format("{} of {} has {} numbers, not {}", field, named(node), numbers.size(), n));
  std::copy(numbers.begin(), numbers.end(), out.begin());
  return out;
}
double valueOf(const Node& node, const char* field, double without) { return valueOf<1>(node, field, {without})[0]; }
bool flagOf(const Node& node, const char* field, bool without) {
  const std::string text = lower(node.attribute(field).value());
  return text.empty() ? without : text == "true";
}

/** Of a solid: what is not above 0 would be turned inside out, or no surface. */
template <std::size_t n>
std::array<double, n> sizeOf(const Node& node, const char* field, const std::array<double, n>& without) {
  const std::array<double, n> sizes = valueOf<n>(node, field, without);
  for (const double size : sizes)
    if (!(size > 0)) refuse(fmt::format("{} of {} is not above 0", field, named(node)));
  return sizes;
}
double sizeOf(const Node& node, const char* field, double without) { return sizeOf<1>(node, field, {without})[0]; }

Eigen::Vector3d vectorOf(const Node& node, const char* field, double without) {
  const auto v = valueOf<3>(node, field, {without, without, without});
  return {v[0], v[1], v[2]};
}
/** `angle_rad` is the file's unit. */
Eigen::Quaterniond turnOf(const Node& node, const char* field, double angle_rad) {
  const auto v = valueOf<4>(node, field, {0, 0, 1, 0});
  const Eigen::Vector3d axis(v[0], v[1], v[2]);
  if (!(axis.norm() > 0)) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(v[3] * angle_rad, axis.normalized()));
}

/** From a group's frame to its parent's. */
Eigen::Affine3d placeOf(const Node& node, double angle_rad) {
  const std::string_view name = node.name();
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  if (name == "DynamicTransform") {  // H3D's, at first.
    out.translate(vectorOf(node, "position", 0)).rotate(turnOf(node, "orientation", angle_rad));
  } else if (name == "Transform" || name == "CADPart") {
    const Eigen::Vector3d centre = vectorOf(node, "center", 0);
    const Eigen::Quaterniond along = turnOf(node, "scaleOrientation", angle_rad);
    out.translate(vectorOf(node, "translation", 0)).translate(centre).rotate(turnOf(node, "rotation", angle_rad));
    out.rotate(along).scale(vectorOf(node, "scale", 1)).rotate(along.conjugate()).translate(-centre);
  }
  return out;
}

unsigned cornerOf(const Node& node, double number) {
  if (number >= 0 && number <= 4294967295.0 && number == std::floor(number)) return static_cast<unsigned>(number);
  refuse(fmt::format("{} names vertex {}", named(node), number));
}

/** Runs of corners: those between -1, or each as long as a count says. */
std::vector<std::vector<unsigned>> runsOf(const Node& node, std::size_t vertices) {
  const bool faces = std::string_view(node.name()) == "IndexedFaceSet";
  std::vector<std::vector<unsigned>> runs;
  if (const char* const index = faces ? "coordIndex" : "index"; std::string_view(node.name()).starts_with("Indexed")) {
    std::vector<unsigned> run;
    for (const double number : numbersOf(node, index)) {
      if (number != -1) {
        run.push_back(cornerOf(node, number));
      } else if (!run.empty()) {
        runs.push_back(std::move(run));
        run = {};
      }
    }
    if (!run.empty()) runs.push_back(std::move(run));
    return runs;
  }
  std::vector<double> counts = numbersOf(node, "stripCount");
  if (counts.empty()) counts = numbersOf(node, "fanCount");
  if (counts.empty()) counts.push_back(static_cast<double>(vertices));
  unsigned next = 0;
  for (const double count : counts) {
    if (!(count >= 0 && count <= static_cast<double>(vertices - next)))
      refuse(fmt::format("{} has {} vertices, and a run of {} after {}", named(node), vertices, count, next));
    runs.emplace_back(static_cast<std::size_t>(count));
    for (unsigned& corner : runs.back()) corner = next++;
  }
  return runs;
}

/** One of the ways in which the standard writes faces; nothing: not this one. */
bool addFaces(const Node& node, const std::vector<std::vector<unsigned>>& runs, Polygons& out) {
  const std::string_view name = node.name();
  const auto is = [name](std::string_view kind) { return name.ends_with(kind); };
  const std::size_t every = is("TriangleSet") ? 3 : is("QuadSet") ? 4 : 0;
  if (every == 0 && !is("IndexedFaceSet") && !is("TriangleStripSet") && !is("TriangleFanSet")) return false;
  for (const auto& run : runs) {
    if (is("IndexedFaceSet")) {
      out.corners.insert(out.corners.end(), run.begin(), run.end());
      out.sizes.push_back(static_cast<unsigned>(run.size()));
    } else if (every != 0) {
      for (std::size_t i = 0; i + every <= run.size(); i += every) {
        for (std::size_t k = 0; k < every; ++k) out.corners.push_back(run[i + k]);
        out.sizes.push_back(static_cast<unsigned>(every));
      }
    } else {
      for (std::size_t i = 2; i < run.size(); ++i) {
        const unsigned a = run[is("TriangleFanSet") ? 0 : i - 2], b = run[i - 1], c = run[i];
        if (a == b || b == c || c == a) continue;  // It joins two strips.
        is("TriangleFanSet") || i % 2 == 0 ? out.add({a, b, c}) : out.add({b, a, c});
      }
    }
  }
  return true;
}

void turnAbout(Polygons& faces) {
  auto first = faces.corners.begin();
  for (const unsigned size : faces.sizes) {
    std::reverse(first, first + size);
    first += size;
  }
}

Polygons gridOf(const Node& node) {
  const double wide = valueOf(node, "xDimension", 0), deep = valueOf(node, "zDimension", 0);
  const std::vector<double> heights = numbersOf(node, "height");
  if (!(wide >= 2 && deep >= 2 && wide * deep == static_cast<double>(heights.size())))
    refuse(fmt::format("{} of {} times {} has {} heights", named(node), wide, deep, heights.size()));
  const double dx = valueOf(node, "xSpacing", 1), dz = valueOf(node, "zSpacing", 1);
  const auto columns = static_cast<unsigned>(wide), rows = static_cast<unsigned>(deep);
  Polygons out;
  for (unsigned i = 0; i < heights.size(); ++i) {
    const unsigned row = i / columns, column = i % columns;
    out.vertices.push_back(
        {static_cast<float>(column * dx), static_cast<float>(heights[i]), static_cast<float>(row * dz)});
  }
  for (unsigned row = 0; row + 1 < rows; ++row) {
    for (unsigned at = row * columns; at + 1 < (row + 1) * columns; ++at)
      out.add({at, at + columns, at + columns + 1, at + 1});
  }
  return out;
}

class Scene {
 public:
  explicit Scene(const std::function<std::string(const std::string&)>& inlined) : inlined_(inlined) {}

  void file(std::string_view bytes, const Eigen::Affine3d& place, int depth) {
    if (documents_.size() == kMostFiles) refuse(fmt::format("names more than {} files", kMostFiles));
    documents_.emplace_back();
    const auto parsed = documents_.back().load_buffer(bytes.data(), bytes.size());
    if (!parsed) refuse(fmt::format("is no whole XML: {} at byte {}", parsed.description(), parsed.offset));
    const Node root = documents_.back().child("X3D");
    if (!root) refuse("is no X3D");
    std::map<std::string, Node> outer;
    outer.swap(names_);                // Each file has its own.
    const Units outer_units = units_;  // `place` has them already.
    units_ = unitsOf(root);
    Eigen::Affine3d scaled = place;
    scaled.scale(units_.length_m / outer_units.length_m);
    group(root, scaled, depth);
    units_ = outer_units;
    names_.swap(outer);
  }

  std::vector<Polygons> shapes;

 private:
  /** Of one file; of another that names none, metres and radians. */
  struct Units {
    double length_m = 1, angle_rad = 1;
  };
  static Units unitsOf(const Node& root) {
    Units out;
    for (const Node unit : root.child("head").children("unit")) {
      const std::string_view category = unit.attribute("category").value();
      if (category == "length") out.length_m = sizeOf(unit, "conversionFactor", 1.0);
      if (category == "angle") out.angle_rad = sizeOf(unit, "conversionFactor", 1.0);
    }
    return out;
  }

  static constexpr int kDeepest = 256;
  static constexpr std::size_t kMostNodes = 10'000'000, kMostFiles = 1000;

  [[noreturn]] static void refuseDepth() { refuse(fmt::format("its nodes are nested more than {} deep", kDeepest)); }

  /** The node itself, or the one that it uses; what has a name is known from now on. */
  Node resolved(const Node& node) {
    if (const std::string name = node.attribute("USE").value(); !name.empty()) {
      const auto found = names_.find(name);
      if (found == names_.end())
        refuse(fmt::format("{} uses '{}', which is not there before it", named(node), shown(name)));
      return found->second;
    }
    if (const char* const name = node.attribute("DEF").value(); *name != 0) names_[name] = node;
    return node;
  }

  void group(const Node& node, const Eigen::Affine3d& parent, int depth) {
    if (depth > kDeepest) refuseDepth();
    if (++nodes_ > kMostNodes) refuse(fmt::format("shows more than {} nodes", kMostNodes));
    const std::string_view name = node.name();
    const Eigen::Affine3d place = parent * placeOf(node, units_.angle_rad);
    if (name == "Inline" && flagOf(node, "load", true)) inlined(node, place, depth);
    const double chosen = name == "Switch" ? valueOf(node, "whichChoice", -1.0) : name == "LOD" ? 0 : -1;
    const bool all = name != "Switch" && name != "LOD";
    std::istringstream visible(name == "CADLayer" ? node.attribute("visible").value() : "");  // A word a child.
    int at = 0;
    for (const Node child : node.children()) {
      if (child.type() != pugi::node_element || isMetadata(child)) continue;
      if (std::string_view(child.attribute("containerField").value()) == "proxy")
        continue;  // Of a Collision: not seen.
      std::string word;
      const bool seen = !(visible >> word) || lower(word) == "true";
      this->child(child, place, depth, (all || at++ == chosen) && seen);
    }
  }

  void child(const Node& child, const Eigen::Affine3d& place, int depth, bool shown) {
    const Node node = resolved(child);
    const std::string_view name = node.name();
    if (isOne(kApart, name)) return;
    shown = shown && (name == "CADLayer" || flagOf(node, "visible", true));
    if (name == "ProtoInstance" && shown) refuseKind("shows a prototype, which is not read");
    if (!shown) return noteNames(node, depth);
    if (name == "Shape") return shape(node, place, depth);
    if (isOne(kGroups, name)) return group(node, place, depth + 1);
    if (node.find_node([](const Node& below) { return std::string_view(below.name()) == "Shape"; }))
      refuseKind(fmt::format("has shapes in a {}, which is not known", named(node)));
    noteNames(node, depth);
  }

  /** What is not shown may be used where it is. */
  void noteNames(const Node& node, int depth) {
    if (depth > kDeepest) refuseDepth();
    for (const Node below : node.children()) {
      if (below.type() != pugi::node_element) continue;
      if (const char* const name = below.attribute("DEF").value(); *name != 0) names_[name] = below;
      noteNames(below, depth + 1);
    }
  }

  static bool isMetadata(const Node& node) { return std::string_view(node.name()).starts_with("Metadata"); }

  void shape(const Node& node, const Eigen::Affine3d& place, int depth) {
    noteNames(node, depth);
    for (const Node child : node.children()) {
      if (child.type() != pugi::node_element || isMetadata(child)) continue;
      const Node geometry = resolved(child);
      if (std::string_view(geometry.name()) == "Appearance") continue;
      if (std::string_view(geometry.attribute("containerField").value()) == "appearance") continue;
      if (++nodes_ > kMostNodes) refuse(fmt::format("shows more than {} nodes", kMostNodes));
      add(geometryOf(geometry), place);
    }
  }

  void add(Polygons faces, const Eigen::Affine3d& place) {
    for (auto& v : faces.vertices) {
      const Eigen::Vector3d at = place * Eigen::Vector3d(double{v[0]}, double{v[1]}, double{v[2]});
      v = {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())};
    }
    if (place.linear().determinant() < 0) turnAbout(faces);
    shapes.push_back(std::move(faces));
  }

  Polygons geometryOf(const Node& node) {
    const std::string_view name = node.name();
    Polygons out;
    if (isOne(kThin, name)) {
      out.sizes.push_back(0);
      return out;
    }
    if (name == "Box") return boxFaces(sizeOf<3>(node, "size", {2, 2, 2}));
    if (name == "Sphere") return ballFaces(sizeOf(node, "radius", 1.0));
    const bool side = flagOf(node, "side", true), bottom = flagOf(node, "bottom", true);
    if (name == "Cylinder") {
      const double radius = sizeOf(node, "radius", 1.0);
      return frustumFaces({radius, radius, sizeOf(node, "height", 2.0), side, bottom, flagOf(node, "top", true)});
    }
    if (name == "Cone")
      return frustumFaces({sizeOf(node, "bottomRadius", 1.0), 0, sizeOf(node, "height", 2.0), side, bottom, false});
    if (name == "ElevationGrid") {
      out = gridOf(node);
    } else {
      for (const Node child : node.children()) {
        if (const Node coordinates = resolved(child); std::string_view(coordinates.name()).starts_with("Coordinate")) {
          const std::vector<double> numbers = numbersOf(coordinates, "point");
          for (std::size_t i = 0; i + 3 <= numbers.size(); i += 3) {
            out.vertices.push_back({static_cast<float>(numbers[i]), static_cast<float>(numbers[i + 1]),
                                    static_cast<float>(numbers[i + 2])});
          }
          if (numbers.size() % 3 != 0) refuse(fmt::format("{} has {} numbers", named(coordinates), numbers.size()));
        }
      }
      if (!addFaces(node, runsOf(node, out.vertices.size()), out))
        refuseKind(fmt::format("has a shape of {}, which is not read", named(node)));
    }
    if (!flagOf(node, "ccw", true)) turnAbout(out);
    return out;
  }

  void inlined(const Node& node, const Eigen::Affine3d& place, int depth) {
    std::string_view rest = node.attribute("url").value();  // "one" "or another"
    for (;;) {
      rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n,\""), rest.size()));
      const std::string_view name = rest.substr(0, rest.find('"'));
      if (name.empty()) break;
      // Beside the file that names it, which need not be the first one.
      const std::filesystem::path path = folder_ / name;
      if (const std::string bytes = inlined_(path.string()); !bytes.empty()) {
        const std::filesystem::path outer = std::exchange(folder_, path.parent_path());
        file(bytes, place, depth + 1);
        folder_ = outer;
        return;
      }
      rest.remove_prefix(name.size());
    }
    throw MeshError(fmt::format("names a file that is not there: {}", shown(node.attribute("url").value(), 60)),
                    "put it beside this one", kBadMesh);
  }

  const std::function<std::string(const std::string&)>& inlined_;
  std::deque<pugi::xml_document> documents_;  ///< Nodes that have names live in them.
  Units units_;
  std::map<std::string, Node> names_;
  std::filesystem::path folder_;  ///< Of the file that is read, from that of the first; as a URI.
  std::size_t nodes_ = 0;
};

}  // namespace

bool isX3d(const std::string& path) { return endsWith(path, ".x3d"); }

std::vector<Polygons> parseX3d(std::string_view bytes, const std::function<std::string(const std::string&)>& inlined) {
  Scene scene(inlined);
  scene.file(bytes, Eigen::Affine3d::Identity(), 0);
  return std::move(scene.shapes);
}

}  // namespace hapticd_mesh_file
