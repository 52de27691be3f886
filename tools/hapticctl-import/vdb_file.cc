#include "tools/hapticctl-import/vdb_file.h"

#include <fmt/core.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>
#include <fstream>

#include "tools/hapticctl-import/image_file.h"

namespace hapticctl_import {
namespace {

constexpr const char* kUnit = "metres_per_unit";  // In a grid's metadata: by our files alone.
constexpr double kHalfWidth = 3;                  // Voxels: what other programs expect of a level set.

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

bool usable(const openvdb::GridBase& grid) { return grid.isType<openvdb::FloatGrid>() && grid.transform().isLinear(); }

std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';  // It goes to a terminal.
  return text;
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
      if (const auto unit = grid->getMetadata<openvdb::DoubleMetadata>(kUnit)) entry.metres_per_unit = unit->value();
      grids.push_back(std::move(entry));
    }
    if (grids.empty())
      throw ImportError({}, "holds no grid of floats that can be used;" + (others.empty() ? " it is empty" : others),
                        "convert the grid to a level set or a fog volume");
    return grids;
  });
}

Image readVdb(const std::string& path, const VdbGrid& entry, double metres_per_unit) {
  return inWords([&] {
    openvdb::io::File file(path);
    file.open(false);
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(entry.name));
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    if (box.empty()) throw ImportError({}, "the grid has no active voxels", "choose another by --grid");
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
    if (count > static_cast<double>(kMostValues))
      throw ImportError("size", fmt::format("{} about the active voxels, more than 2^31", count),
                        "resample the grid elsewhere first");
    image.values.reserve(static_cast<std::size_t>(count));
    const auto values = grid->getConstAccessor();
    openvdb::Coord c;
    for (c.z() = box.min().z(); c.z() <= box.max().z(); ++c.z())
      for (c.y() = box.min().y(); c.y() <= box.max().y(); ++c.y())
        for (c.x() = box.min().x(); c.x() <= box.max().x(); ++c.x()) {
          const float v = values.getValue(c);
          image.values.push_back(std::isfinite(v) ? v : grid->background());
        }
    requireTwo(image, "size");
    checkPlace(image);
    return image;
  });
}

void writeVdb(const std::string& path, const hapticd::VolumeView& volume) {
  inWords([&] {
    const double voxel = static_cast<double>(volume.voxel);
    const auto band = static_cast<float>(kHalfWidth * voxel);
    const auto grid = openvdb::FloatGrid::create(band);
    const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
    transform->postTranslate(openvdb::Vec3d(static_cast<double>(volume.origin[0]),
                                            static_cast<double>(volume.origin[1]),
                                            static_cast<double>(volume.origin[2])));
    grid->setTransform(transform);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    grid->setName("surface");
    grid->insertMeta(kUnit, openvdb::DoubleMetadata(1.0));
    auto values = grid->getAccessor();
    const std::uint32_t *const cells = volume.cell, nx = volume.cells[0], ny = volume.cells[1], nz = volume.cells[2];
    for (std::uint32_t cell = 0; cell < nx * ny * nz; ++cell) {
      if (cells[cell] == HD_NO_INDEX) continue;
      const std::int16_t* sample = volume.bricks + std::size_t{HD_BRICK_STRIDE} * cells[cell];
      const openvdb::Coord first(static_cast<int>(HD_BRICK_EDGE * (cell % nx)),
                                 static_cast<int>(HD_BRICK_EDGE * (cell / nx % ny)),
                                 static_cast<int>(HD_BRICK_EDGE * (cell / nx / ny)));
      const int n = HD_BRICK_SAMPLES;
      for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x) {
            const float d = static_cast<float>(*sample++) * volume.fine_step;
            if (std::abs(d) < band) values.setValue(first.offsetBy(x, y, z), d);
          }
    }
    openvdb::tools::signedFloodFill(grid->tree());
    grid->pruneGrid();
    openvdb::io::File file(path);
    file.write({grid});
  });
}

}  // namespace hapticctl_import
