/** @file
 * What OpenVDB's format lacks: whether a grid is as it was written. For files that include OpenVDB anyway.
 */
#pragma once

#include <fmt/core.h>
#include <openvdb/openvdb.h>

#include <bit>
#include <sstream>
#include <string>

#include "daemon/builder/vdb/write_vdb.h"
#include "proto/snapshot.h"

namespace hapticd {

/** Whether an entry of metadata is one that OpenVDB itself writes, of what it counts. */
[[nodiscard]] inline bool isOpenVdbs(const std::string& key) { return key.rfind("file_", 0) == 0; }

/**
 * Of the place, the background, every tile and every active voxel of a grid with 4-byte values, of its metadata but the
 * sum itself and OpenVDB's, and of the file's metadata; in hexadecimal.
 */
template <class Grid>
[[nodiscard]] std::string checksumOf(const Grid& grid, const openvdb::MetaMap& file) {
  using Value = typename Grid::ValueType;
  static_assert(sizeof(Value) == 4);
  std::uint64_t sum = HD_CHECKSUM_BASIS;
  const auto add = [&](std::uint64_t word) { sum = std::rotl((sum ^ word) * HD_CHECKSUM_PRIME, 29); };
  const auto addPlace = [&](const openvdb::Coord& c) {
    for (int k = 0; k < 3; ++k) add(static_cast<std::uint32_t>(c[k]));
  };
  const auto addText = [&](const std::string& text) {
    add(text.size());
    for (const char c : text) add(static_cast<unsigned char>(c));
  };
  for (const openvdb::MetaMap* map : {static_cast<const openvdb::MetaMap*>(&grid), &file}) {
    for (auto entry = map->beginMeta(); entry != map->endMeta(); ++entry) {
      if (entry->first == kVdbChecksum || isOpenVdbs(entry->first)) continue;
      std::ostringstream value;  // As in the file: in words a double is rounded.
      entry->second->write(value);
      for (const std::string& text : {entry->first, entry->second->typeName(), value.str()}) addText(text);
    }
  }
  add(std::bit_cast<std::uint32_t>(grid.background()));
  for (const openvdb::Vec3d& corner : {openvdb::Vec3d(0, 0, 0), openvdb::Vec3d(1, 1, 1)}) {
    const openvdb::Vec3d place = grid.indexToWorld(corner);
    for (int k = 0; k < 3; ++k) add(std::bit_cast<std::uint64_t>(place[k]));
  }
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(Grid::TreeType::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    addPlace(tile.getCoord());
    add(std::uint64_t{std::bit_cast<std::uint32_t>(tile.getValue())} << 1 | (tile.isValueOn() ? 1 : 0));
  }
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    addPlace(leaf->origin());
    for (auto value = leaf->cbeginValueOn(); value; ++value)
      add(std::uint64_t{std::bit_cast<std::uint32_t>(*value)} << 32 | value.pos());
  }
  return fmt::format("{:016x}", sum);
}

}  // namespace hapticd
