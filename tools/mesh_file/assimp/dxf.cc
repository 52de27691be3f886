#include "tools/mesh_file/assimp/dxf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tools/mesh_file/mesh_error.h"
#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

/** A group: a code that says what the value is, each in a line of its own. */
struct Group {
  int code = 0;
  std::string_view value;
};

std::string_view takeWholeLine(std::string_view& text) {
  std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(text.size(), line.size() + 1));
  line = line.substr(0, line.find_last_not_of(" \t\r") + 1);
  return line.substr(std::min(line.size(), line.find_first_not_of(" \t")));
}

/** False: there is none, or what follows is no DXF in words. */
bool takeGroup(std::string_view& text, Group& group) {
  if (text.empty()) return false;
  const auto code = numberIn(takeWholeLine(text));
  if (!code || std::abs(*code) > 10000) return false;
  group = {static_cast<int>(*code), takeWholeLine(text)};
  return true;
}

/** How a block is inserted. */
struct Insert {
  std::string block;
  std::map<int, double> numbers;  ///< By their codes.

  [[nodiscard]] double number(int code, double otherwise) const {
    const auto found = numbers.find(code);
    return found == numbers.end() ? otherwise : found->second;
  }
  /** What of it is not read; null: nothing. `base`: the block's is not the origin. */
  [[nodiscard]] const char* notRead(bool base) const {
    if (std::remainder(number(50, 0), 360) != 0) return "turned";
    if (number(70, 1) > 1 || number(71, 1) > 1) return "in rows";
    if (number(230, 1) != 1) return "upside down or on its side";
    bool scaled = false, mirrored = false, shifted = base;
    for (const int axis : {0, 1, 2}) {
      scaled = scaled || number(41 + axis, 1) != 1;
      mirrored = mirrored || !(number(41 + axis, 1) > 0);
      shifted = shifted || number(10 * (axis + 1), 0) != 0;
    }
    return mirrored ? "mirrored" : scaled && shifted ? "scaled beside the origin" : nullptr;
  }
};

struct Block {
  bool faces = false;  ///< Of its own.
  bool base = false;   ///< It has one that is not the origin.
  std::vector<Insert> inserts;
};

/** Blocks by name; what stands in none is that of no name. */
std::map<std::string, Block> blocksOf(std::string_view text) {
  std::map<std::string, Block> blocks;
  std::string entity, block;
  Insert* insert = nullptr;
  for (Group group; takeGroup(text, group);) {
    if (group.code == 0) {
      insert = nullptr;
      entity = group.value;
      if (entity == "SECTION" || entity == "BLOCK" || entity == "ENDBLK") block.clear();
      if (entity == "3DFACE") blocks[block].faces = true;
      if (entity == "INSERT") insert = &blocks[block].inserts.emplace_back();
    } else if (group.code == 2 && entity == "BLOCK") {
      block = group.value;
    } else if (entity == "BLOCK" && (group.code == 10 || group.code == 20 || group.code == 30)) {
      Block& at = blocks[block];
      at.base = at.base || numberIn(group.value) != 0.0;
    } else if (group.code == 70 && entity == "POLYLINE") {
      constexpr int kPolygons = 16, kFaces = 64;  // Else it is a line.
      const auto flags = static_cast<int>(std::clamp(numberIn(group.value).value_or(0), 0.0, 1024.0));
      if ((flags & (kPolygons | kFaces)) != 0) blocks[block].faces = true;
    } else if (group.code == 2 && insert != nullptr) {
      insert->block = group.value;
    } else if (insert != nullptr) {
      insert->numbers.emplace(group.code, numberIn(group.value).value_or(0));
    }
  }
  return blocks;
}

}  // namespace

void requirePlainInserts(std::string_view bytes) {
  std::map<std::string, Block> blocks = blocksOf(withoutMark(bytes));
  const auto shows = [&blocks](const Insert& insert) {
    const auto block = blocks.find(insert.block);
    return block != blocks.end() && block->second.faces;
  };
  for (const auto& [name, block] : blocks) {
    for (const Insert& insert : block.inserts) {
      if (!shows(insert)) continue;
      const char* const how = name.empty() ? insert.notRead(blocks[insert.block].base) : "in another block";
      if (how == nullptr) continue;
      throw MeshError(fmt::format("inserts the block '{}' {}, which is not read", shown(insert.block, 60), how),
                      "explode its blocks before the export, or export another format", kBadMesh);
    }
  }
}

}  // namespace hapticd_mesh_file
