#include "tools/mesh_file/own/stl.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>

#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

constexpr std::size_t kBeforeTriangles = 84, kTriangle = 50, kNormal = 12;  ///< Bytes of binary STL.

/** What a binary STL of as many triangles as it says would have; 0: it says nothing. */
std::uint64_t bytesIfBinary(std::string_view bytes, std::uint64_t& triangles) {
  if (bytes.size() < kBeforeTriangles) return 0;
  for (std::size_t i = 0; i < 4; ++i)
    triangles |= std::uint64_t{static_cast<unsigned char>(bytes[kBeforeTriangles - 4 + i])} << 8 * i;
  return kBeforeTriangles + kTriangle * triangles;
}

Polygons binaryStl(std::string_view bytes, std::uint64_t triangles) {
  Polygons out;
  out.vertices.resize(3 * triangles);
  for (std::size_t i = 0; i < triangles; ++i) {
    const auto first = static_cast<unsigned>(3 * i);
    std::memcpy(out.vertices[first].data(), bytes.data() + kBeforeTriangles + kTriangle * i + kNormal,
                3 * sizeof out.vertices[0]);
    out.add({first, first + 1, first + 2});
  }
  return out;
}

/** STL in words. */
class Facets {
 public:
  explicit Facets(std::string_view text) : rest_(text) {}

  Polygons read() {
    for (;;) {
      const std::string key = lower(takeWord(rest_));
      if (key.empty()) return std::move(out_);
      if (key == "facet") {
        facet();
      } else if (key == "outer" || key == "vertex" || key == "endloop" || key == "endfacet") {
        refuse(fmt::format("'{}' stands behind facet {}, in none", key, out_.sizes.size()));
      } else {
        (void)takeLine(rest_);  // Names of solids may say anything.
      }
    }
  }

 private:
  std::string_view next() {
    const std::string_view word = takeWord(rest_);
    if (word.empty()) refuseEnd();
    return word;
  }
  [[noreturn]] static void refuseEnd() { refuse("is cut short: its last facet has no end"); }
  [[noreturn]] void refuseAt(std::string_view word, const char* what) const {
    if (std::string_view behind = rest_; takeWord(behind).empty()) refuseEnd();  // The word may have lost its end.
    refuse(fmt::format("facet {}: '{}' {}", out_.sizes.size() + 1, shown(word), what));
  }

  void facet() {
    for (std::string key; key != "outer";) {  // Some write a normal as "-1.#IND", and no two need it.
      const std::string_view word = next();
      key = lower(word);
      if (key == "vertex" || key == "facet" || key == "endfacet") refuseAt(word, "stands where 'outer loop' should");
    }
    if (const std::string_view word = next(); lower(word) != "loop") refuseAt(word, "stands where 'loop' should");
    unsigned corners = 0;
    for (;;) {
      const std::string_view word = next();
      if (lower(word) == "endloop") break;
      if (lower(word) != "vertex") refuseAt(word, "stands where 'vertex' should");
      std::array<float, 3> corner{};
      for (float& x : corner) {
        const std::string_view number = next();
        const auto value = numberIn(number);
        if (!value) refuseAt(number, "is not a number");
        x = static_cast<float>(*value);
      }
      out_.corners.push_back(static_cast<unsigned>(out_.vertices.size()));
      out_.vertices.push_back(corner);
      ++corners;
    }
    if (const std::string_view word = next(); lower(word) != "endfacet")
      refuseAt(word, "stands where 'endfacet' should");
    out_.sizes.push_back(corners);
  }

  std::string_view rest_;
  Polygons out_;
};

}  // namespace

Polygons parseStl(std::string_view bytes) {
  std::uint64_t triangles = 0;
  // With less than a triangle to spare: some programs end it with a line's end, or fill a block.
  if (const std::uint64_t needed = bytesIfBinary(bytes, triangles);
      needed > 0 && bytes.size() >= needed && bytes.size() < needed + kTriangle)
    return binaryStl(bytes, triangles);
  const std::string_view text = withoutMark(bytes);
  if (std::string_view first = text;
      lower(takeWord(first)) == "solid" && bytes.substr(0, kBeforeTriangles).find('\0') == bytes.npos)
    return Facets(text).read();
  refuse(bytes.size() < kBeforeTriangles
             ? "is no STL"
             : fmt::format("is no STL in words ('solid'), and of {} bytes; binary STL of {} triangles has {}",
                           bytes.size(), triangles, kBeforeTriangles + kTriangle * triangles));
}

}  // namespace hapticd_mesh_file
