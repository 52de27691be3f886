#include "tools/hapticctl-import/format/vdb_file.h"

#include <fmt/core.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <fstream>

#include "daemon/builder/vdb/vdb_checksum.h"
#include "daemon/builder/vdb/write_vdb.h"
#include "tools/hapticctl-import/format/image_file.h"

namespace hapticctl_import {
namespace {

using openvdb::FloatGrid;

/** What OpenVDB throws, in words. */
template <class Work>
auto inWords(Work&& work) {
  try {
    openvdb::initialize();
    return work();
  } catch (const openvdb::Exception& error) {
    throw ImportError({}, error.what(), "is the file whole?");
  }
}

bool usable(const openvdb::GridBase& grid) {
  return (grid.isType<FloatGrid>() || grid.isType<openvdb::DoubleGrid>()) && grid.transform().isLinear();
}

/** As floats, whichever of the two it has. */
FloatGrid::ConstPtr floatsOf(const openvdb::GridBase::Ptr& grid) {
  if (const auto doubles = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid))
    return std::make_shared<FloatGrid>(*doubles);
  return openvdb::gridPtrCast<FloatGrid>(grid);
}

std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';  // It goes to a terminal.
  return text;
}

/** Whether it was written by hapticd or this program; a name of the metadata may be wrong. */
bool isOurs(const openvdb::MetaMap& file, const openvdb::GridBase& grid) {
  for (const openvdb::MetaMap* map : {&file, static_cast<const openvdb::MetaMap*>(&grid)}) {
    for (auto entry = map->beginMeta(); entry != map->endMeta(); ++entry)
      if (entry->first.rfind("hapticd", 0) == 0) return true;
  }
  return false;
}

/** What the sum is of, and what OpenVDB says of the voxels, against what was read. */
void requireAsWritten(const openvdb::MetaMap& file, const FloatGrid& grid, const std::string& name,
                      const openvdb::CoordBBox& box) {
  const auto sum = grid.getMetadata<openvdb::StringMetadata>(hapticd::kVdbChecksum);
  if (!sum || sum->value() != hapticd::checksumOf(grid, file)) {
    throw ImportError({}, "is damaged, of another version, or was changed: the checksum of hapticd does not match",
                      "write it again; if a program changed it as it should, take the metadata hapticd_... out of its "
                      "file and grids there");
  }
  const auto voxels = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  if (name == grid.getName() && voxels && low && high &&
      static_cast<openvdb::Index64>(voxels->value()) == grid.activeVoxelCount() &&
      low->value() == box.min().asVec3i() && high->value() == box.max().asVec3i())
    return;
  throw ImportError({}, "is damaged: its metadata tell of other voxels than stand in it", "write it again");
}

}  // namespace

bool isVdb(const std::string& path) {
  char magic[8] = {};
  std::ifstream(path, std::ios::binary).read(magic, sizeof magic);
  return std::string(magic, 4) == " BDV";  // 0x56444220, little endian.
}

std::vector<VdbGrid> gridsOf(const std::string& path) {
  return inWords([&] {
    openvdb::io::File file(path);
    file.open(false);
    std::vector<VdbGrid> grids;
    std::string others;
    for (auto name = file.beginName(); name != file.endName(); ++name) {
      const auto grid = file.readGridMetadata(*name);
      if (!usable(*grid)) {
        others += fmt::format(" {} ({})", printable(*name), grid->valueType());
        continue;
      }
      VdbGrid entry;
      entry.name = *name;
      const auto voxels = grid->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
      entry.text = fmt::format("{}, {}{}", printable(*name),
                               grid->getGridClass() == openvdb::GRID_LEVEL_SET ? "level set" : "fog volume",
                               voxels ? fmt::format(", {} voxels", voxels->value()) : "");
      if (const auto unit = grid->getMetadata<openvdb::DoubleMetadata>(hapticd::kVdbUnit))
        entry.metres_per_unit = unit->value();
      grids.push_back(std::move(entry));
    }
    if (grids.empty()) {
      throw ImportError({}, "holds no grid of floats that can be used;" + (others.empty() ? " it is empty" : others),
                        "convert the grid to a level set or a fog volume");
    }
    return grids;
  });
}

Image readVdb(const std::string& path, const VdbGrid& entry, double metres_per_unit) {
  return inWords([&] {
    openvdb::io::File file(path);
    file.open(false);
    const FloatGrid::ConstPtr grid = floatsOf(file.readGrid(entry.name));
    openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    if (const auto meta = file.getMetadata(); isOurs(*meta, *grid)) requireAsWritten(*meta, *grid, entry.name, box);
    if (box.empty()) throw ImportError({}, "the grid has no active voxels", "choose another by --grid");
    for (int k = 0; k < 3; ++k) {  // So far out that one more can be counted.
      if (box.min()[k] > openvdb::Coord::min()[k] && box.max()[k] < openvdb::Coord::max()[k]) continue;
      throw ImportError("size", "voxels as far out as can be", "resample the grid elsewhere first");
    }
    box.expand(1);  // What is about them is known, too: the surface lies between the two.
    Image image;
    image.distances = grid->getGridClass() == openvdb::GRID_LEVEL_SET;
    image.usual_iso = image.distances ? 0.0f : 0.5f;
    image.format = "OpenVDB, " + entry.text;
    double count = 1;
    const double mm = metres_per_unit * 1e3;
    const openvdb::Vec3d origin = grid->indexToWorld(box.min());
    for (int k = 0; k < 3; ++k) {
      const auto n = static_cast<std::int64_t>(box.max()[k]) - box.min()[k] + 1;
      if (n > 65536) throw ImportError("size", fmt::format("{} values along an axis", n), "2 to 65536 can be");
      image.size[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(n);
      count *= static_cast<double>(n);
      openvdb::Vec3d next = box.min().asVec3d();
      next[k] += 1;
      const openvdb::Vec3d step = grid->indexToWorld(next) - origin;
      for (int a = 0; a < 3; ++a) image.step[static_cast<std::size_t>(k)][static_cast<std::size_t>(a)] = step[a] * mm;
      image.origin[static_cast<std::size_t>(k)] = origin[k] * mm;
    }
    if (count > static_cast<double>(kMostValues)) {
      throw ImportError("size", fmt::format("{} about the active voxels, more than 2^31", count),
                        "resample the grid elsewhere first");
    }
    image.values.reserve(static_cast<std::size_t>(count));
    const auto values = grid->getConstAccessor();
    openvdb::Coord c;
    for (c.z() = box.min().z(); c.z() <= box.max().z(); ++c.z()) {
      for (c.y() = box.min().y(); c.y() <= box.max().y(); ++c.y()) {
        for (c.x() = box.min().x(); c.x() <= box.max().x(); ++c.x()) {
          const float v = values.getValue(c);
          image.values.push_back(std::isfinite(v) ? v : grid->background());
        }
      }
    }
    requireTwo(image, "size");
    checkPlace(image);
    return image;
  });
}

}  // namespace hapticctl_import
