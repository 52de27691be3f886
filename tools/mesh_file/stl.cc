#include "tools/mesh_file/stl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string_view>

namespace hapticd_mesh_file {
namespace {

constexpr std::streamoff kBeforeTriangles = 84, kTriangle = 50;  ///< Bytes of binary STL.

/** What a binary STL of as many triangles as it says would have; 0: it says nothing. */
std::uint64_t bytesIfBinary(std::ifstream& file, std::uint64_t& triangles) {
  unsigned char count[4];
  if (!file.seekg(kBeforeTriangles - 4).read(reinterpret_cast<char*>(count), sizeof count)) return 0;
  triangles = count[0] | std::uint64_t{count[1]} << 8 | std::uint64_t{count[2]} << 16 | std::uint64_t{count[3]} << 24;
  return kBeforeTriangles + kTriangle * triangles;
}

}  // namespace

std::string whyNoStl(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(0, file.tellg()));
  std::uint64_t triangles = 0;
  const std::uint64_t needed = bytesIfBinary(file, triangles);
  return needed == 0 ? "is no STL"
                     : fmt::format("is no STL in words ('solid'), and of {} bytes; binary STL of {} triangles has {}",
                                   size, triangles, needed);
}

bool endsInAFacet(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  std::uint64_t triangles = 0;
  if (size < kBeforeTriangles || bytesIfBinary(file, triangles) == static_cast<std::uint64_t>(size)) return false;
  std::string text(static_cast<std::size_t>(std::min<std::streamoff>(size, 4096)), '\0');
  file.seekg(size - static_cast<std::streamoff>(text.size()));
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  bool open = false;
  for (std::string_view rest = text; !rest.empty();) {  // Line by line: names of solids may say anything.
    std::string_view line = rest.substr(0, rest.find_first_of("\r\n"));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    line.remove_prefix(std::min(line.size(), line.find_first_not_of(" \t")));
    if (line.substr(0, 5) == "facet") {  // In one line there may be all of it, or of them.
      const std::size_t last = line.rfind("facet");
      open = last < 3 || line.substr(last - 3, 3) != "end";
    }
    if (line.substr(0, 8) == "endfacet" || line.substr(0, 8) == "endsolid") open = false;
  }
  return open;
}

}  // namespace hapticd_mesh_file
