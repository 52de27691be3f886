#include "tools/mesh_file/assimp/three_mf.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <pugixml.hpp>
#include <set>
#include <string>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

/** Little-endian; 0 where nothing stands. */
std::size_t wordAt(std::string_view bytes, std::size_t at, std::size_t size) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < size && at + i < bytes.size(); ++i)
    value |= std::size_t{static_cast<unsigned char>(bytes[at + i])} << 8 * i;
  return value;
}

/** As far as it is whole. */
std::string inflated(std::string_view packed) {
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  std::string out;
  std::array<char, 65536> some;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // It only reads.
  stream.avail_in = static_cast<uInt>(packed.size());
  for (int state = Z_OK; state == Z_OK;) {
    stream.next_out = reinterpret_cast<Bytef*>(some.data());
    stream.avail_out = some.size();
    state = inflate(&stream, Z_NO_FLUSH);
    out.append(some.data(), some.size() - stream.avail_out);
  }
  (void)inflateEnd(&stream);
  return out;
}

/** A file of an archive, by its entry in the directory. */
std::string unpacked(std::string_view zip, std::size_t entry) {
  constexpr std::size_t kHeader = 30;
  const std::size_t method = wordAt(zip, entry + 10, 2), size = wordAt(zip, entry + 20, 4);
  const std::size_t header = wordAt(zip, entry + 42, 4);
  const std::size_t begin = header + kHeader + wordAt(zip, header + 26, 2) + wordAt(zip, header + 28, 2);
  const std::string_view bytes = zip.substr(std::min(begin, zip.size()), size);
  return method == 8 ? inflated(bytes) : method == 0 ? std::string(bytes) : std::string();
}

void requireModelsOnlyIn(const std::string& xml) {
  pugi::xml_document file;
  if (!file.load_buffer(xml.data(), xml.size())) return;  // assimp says why.
  std::set<std::string_view> shown_ids;
  for (const auto& shows : file.select_nodes("//build/item | //component"))
    shown_ids.insert(shows.node().attribute("objectid").value());
  for (const auto& found : file.select_nodes("//object[@type]")) {
    const std::string_view id = found.node().attribute("id").value(), type = found.node().attribute("type").value();
    if (type == "model" || type == "surface" || shown_ids.count(id) == 0) continue;
    throw MeshError(
        fmt::format("shows an object that is no part of the model: {} is of type '{}'", shown(id), shown(type)),
        "delete it in the program that made it, or export the model as STL", kBadMesh);
  }
}

}  // namespace

void requireModelsOnly(std::string_view bytes) {
  constexpr std::string_view kEnd = "PK\5\6", kEntry = "PK\1\2", kModel = ".model";
  const std::size_t end = bytes.rfind(kEnd);
  if (end == bytes.npos) return;
  std::size_t at = wordAt(bytes, end + 16, 4);
  while (at < end && bytes.substr(at, kEntry.size()) == kEntry) {
    const std::size_t name = wordAt(bytes, at + 28, 2);
    if (lower(bytes.substr(std::min(at + 46, bytes.size()), name)).ends_with(kModel))
      requireModelsOnlyIn(unpacked(bytes, at));
    at += 46 + name + wordAt(bytes, at + 30, 2) + wordAt(bytes, at + 32, 2);
  }
}

}  // namespace hapticd_mesh_file
