#include "tools/mesh_file/own/off.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

class Off {
 public:
  explicit Off(std::string_view text) : rest_(text) {}

  Polygons read() {
    std::string_view line = nextLine();
    if (std::string_view words = line; takeWord(words).find("OFF") != line.npos) {
      requirePlain(line);
      line.remove_prefix(line.find("OFF") + 3);  // Of ModelNet's files the counts follow without a blank.
      if (line.find_first_not_of(" \t") == line.npos) line = nextLine();
    }
    const std::uint64_t vertices = count(line, "vertices"), faces = count(line, "faces");
    Polygons out;
    for (std::uint64_t i = 0; i < vertices; ++i) {
      line = lineOf("vertex", i, vertices);
      std::array<float, 3> place{};
      for (float& x : place) x = static_cast<float>(number(line));
      out.vertices.push_back(place);
    }
    for (std::uint64_t i = 0; i < faces; ++i) {
      line = lineOf("face", i, faces);
      const double corners = number(line);
      if (!(corners >= 0) || corners != std::floor(corners)) refuse(fmt::format("{} has {} corners", where_, corners));
      unsigned size = 0;
      for (; size < corners; ++size) {  // However many it says: its line has an end.
        const double vertex = number(line);
        if (!(vertex >= 0 && vertex < static_cast<double>(vertices)) || vertex != std::floor(vertex))
          refuse(fmt::format("{} names vertex {} of {}", where_, vertex, vertices));
        out.corners.push_back(static_cast<unsigned>(vertex));
      }
      out.sizes.push_back(size);
    }
    line = nextLine();
    if (numberIn(takeWord(line)))
      refuse(fmt::format("has more lines than its {} vertices and {} faces", vertices, faces));
    return out;
  }

 private:
  /** The next one that is not empty, without its comment; empty: there is none. */
  std::string_view nextLine() {
    while (!rest_.empty()) {
      std::string_view line = takeLine(rest_);
      line = line.substr(0, line.find('#'));
      if (line.find_first_not_of(" \t\v\f") != line.npos) return line;
    }
    return {};
  }

  std::string_view lineOf(const char* what, std::uint64_t i, std::uint64_t all) {
    where_ = fmt::format("{} {} of {}", what, i, all);
    const std::string_view line = nextLine();
    if (line.empty()) refuse("is cut short: it ends before " + where_);
    return line;
  }

  /** Its first line may say that places have four numbers or more, or are not in words. */
  static void requirePlain(std::string_view line) {
    const std::string_view kind = takeWord(line), form = takeWord(line);
    if (kind.substr(0, kind.find("OFF")).find_first_of("4n") == kind.npos && form != "BINARY") return;
    throw MeshError(fmt::format("is OFF of a kind that is not read: '{} {}'", shown(kind), shown(form)),
                    "export it as plain OFF, or PLY", kBadMesh);
  }

  static std::uint64_t count(std::string_view& line, const char* what) {
    const std::string_view word = takeWord(line);
    const double value = numberIn(word).value_or(-1);
    if (!(value >= 0 && value <= 4294967295.0) || value != std::floor(value))
      refuse(fmt::format("does not say how many {} it has: '{}'", what, shown(word)));
    return static_cast<std::uint64_t>(value);
  }

  [[nodiscard]] double number(std::string_view& line) const {
    const std::string_view word = takeWord(line);
    if (word.empty()) refuse(where_ + " has too few numbers in its line");
    const auto value = numberIn(word);
    if (!value) refuse(fmt::format("{}: '{}' is not a number", where_, shown(word)));
    return *value;
  }

  std::string_view rest_;
  std::string where_;
};

}  // namespace

bool isOff(const std::string& path) {
  if (endsWith(path, ".off")) return true;
  char first[3] = {};
  std::ifstream(path, std::ios::binary).read(first, sizeof first);
  return std::string_view(first, sizeof first) == "OFF";
}

Polygons parseOff(std::string_view bytes) { return Off(withoutMark(bytes)).read(); }

}  // namespace hapticd_mesh_file
