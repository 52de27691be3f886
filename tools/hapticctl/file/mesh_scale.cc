#include "tools/hapticctl/file/mesh_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/lengths.h"
#include "tools/hapticctl/numbers.h"

namespace hapticctl {
namespace {

constexpr std::size_t kAdvised = 4;  // Of the units: those that mesh files are usually in.

/** Formats that say their unit, or have one. */
struct Format {
  const char* ending;
  const char *why, *advice;
};
constexpr const char *kNotRead = "the unit that the file names is not read", *kMetres = "its format is read in metres";
constexpr Format kFormats[] = {
    {".gltf", kMetres, "glTF is in metres by its standard: --scale m"},
    {".glb", kMetres, "glTF is in metres by its standard: --scale m"},
    {".x3d", kMetres, "X3D is read in metres, by the unit that it names if it names one: --scale m"},
    {".dae", kMetres, "COLLADA is read in metres, whatever unit it names: --scale m"},
    {".fbx", kNotRead, "FBX is in cm unless it names another: --scale cm"},
    {".3mf", kNotRead, "3MF is in mm unless it names another: --scale mm"},
    {".amf", kNotRead, "AMF is in mm unless it names another: --scale mm"}};

const Format* formatOf(const MeshFile& mesh) {
  std::string path = mesh.path;
  for (char& c : path) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  const auto* const found = std::find_if(std::begin(kFormats), std::end(kFormats),
                                         [&](const Format& format) { return path.ends_with(format.ending); });
  return found == std::end(kFormats) ? nullptr : found;
}

}  // namespace

double parseScale(std::string_view text) {
  if (const Unit* const unit = findUnit(text)) return unit->inMetres(1);
  const auto value = parseNumber(text);
  if (!value || !(*value > 0)) {
    failUsage("--scale", fmt::format("'{}' is neither a unit nor a positive number", text),
              "write the file's unit (mm, cm, m, inch, um, ft) or metres per file unit (0.001)");
  }
  return *value;
}

std::string whyScale(const MeshFile& mesh) {
  const Format* const format = formatOf(mesh);
  return format == nullptr ? "the file does not say its unit" : format->why;
}

std::string scaleAdvice(const MeshFile& mesh) {
  std::array<double, 3> side{};
  for (std::size_t i = 0; i < 3; ++i) side[i] = mesh.upper[i] - mesh.lower[i];
  std::string text = fmt::format("its box is {:.6g} x {:.6g} x {:.6g} file units, from ({:.6g}, {:.6g}, {:.6g})\n",
                                 side[0], side[1], side[2], mesh.lower[0], mesh.lower[1], mesh.lower[2]);
  for (std::size_t u = 0; u < kAdvised; ++u) {
    text +=
        fmt::format("--scale {:<7} would make it {} x {} x {}\n", kUnits[u].name, length(kUnits[u].inMetres(side[0])),
                    length(kUnits[u].inMetres(side[1])), length(kUnits[u].inMetres(side[2])));
  }
  text += "--scale NUMBER  metres per file unit;  --size METRES  makes the longest side that long";
  if (const Format* const format = formatOf(mesh)) text += fmt::format("\n{}", format->advice);
  return text;
}

void centre(MeshFile& mesh) {
  for (auto& v : mesh.vertices) {
    for (std::size_t i = 0; i < 3; ++i) v[i] = static_cast<float>(v[i] - 0.5 * (mesh.lower[i] + mesh.upper[i]));
  }
  measure(mesh);
}

void scale(MeshFile& mesh, double metres_per_unit, const char* option) {
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
    failUsage(option,
              fmt::format("{} metres per unit make the longest side of {} {:.3g} m: from {:g} to {:g} m it can be",
                          metres_per_unit, mesh.path, longest, kLeast_m, kMost_m),
              scaleAdvice(before));
  }
}

std::string sizeNote(const MeshFile& mesh) {
  constexpr double kSmall_m = 1e-3, kLarge_m = 2;  // Between them is what hands touch.
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, mesh.upper[i] - mesh.lower[i]);
  if (longest >= kSmall_m && longest < kLarge_m) return {};
  return fmt::format("--scale: the longest side of {} is {}; if that is not meant, name the file's unit, as --scale {}",
                     mesh.path, length(longest), longest < kSmall_m ? "m" : "mm");
}

}  // namespace hapticctl
