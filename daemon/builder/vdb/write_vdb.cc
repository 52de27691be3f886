#include "daemon/builder/vdb/write_vdb.h"

#include <openvdb/io/Archive.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <ostream>
#include <sstream>
#include <vector>

#include "daemon/builder/vdb/band.h"
#include "daemon/builder/vdb/vdb_checksum.h"
#include "daemon/version.h"

namespace hapticd {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Int32Grid;

/** To a stream as to a file: with the places of the grids, so that one can be read without the others. */
class Archive final : public openvdb::io::Archive {
 public:
  void put(std::ostream& out, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& meta) const {
    write(out, grids, true, meta);
  }
};

template <class Grid>
void describe(Grid& grid, const char* name, const VolumeView& volume, double shift_voxels,
              const openvdb::MetaMap& file) {
  const double voxel = double{volume.voxel};
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  transform->postTranslate(openvdb::Vec3d(double{volume.origin[0]} + shift_voxels * voxel,
                                          double{volume.origin[1]} + shift_voxels * voxel,
                                          double{volume.origin[2]} + shift_voxels * voxel));
  grid.setTransform(transform);
  grid.setName(name);
  grid.insertMeta(kVdbUnit, openvdb::DoubleMetadata(1.0));
  grid.insertMeta(kVdbChecksum, openvdb::StringMetadata(checksumOf(grid, file)));
}

/** In metres. Rounded up: OpenVDB's check of level sets refuses a background that is less by the last bit. */
float bandOf(double voxel) {
  const auto band = static_cast<float>(kVdbHalfWidth * voxel);
  return double{band} / voxel < kVdbHalfWidth ? std::nextafter(band, INFINITY) : band;
}

FloatGrid::Ptr surfaceOf(const VolumeView& volume, DistanceField* field, const openvdb::MetaMap& file) {
  const float band = bandOf(double{volume.voxel});
  auto grid = FloatGrid::create(band);
  auto values = grid->getAccessor();
  visitBand(volume, field, double{band}, [&](const Lattice3& first, std::span<const float, HD_BRICK_VALUES> distances) {
    constexpr int kSide = HD_BRICK_SAMPLES;
    const Coord begin(first[0], first[1], first[2]);
    const float* d = distances.data();
    for (int z = 0; z < kSide; ++z) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x, ++d)
          if (std::abs(*d) < band) values.setValue(begin.offsetBy(x, y, z), *d);
      }
    }
  });
  openvdb::tools::signedFloodFill(grid->tree(), false);
  grid->pruneGrid();
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  describe(*grid, "surface", volume, 0, file);
  return grid;
}

/** The octree's voxels; a node that is full is one tile or few. */
class States {
 public:
  States(const VolumeView& volume, const openvdb::MetaMap& file)
      : octree_(volume.octree), values_(grid_->getAccessor()) {
    descend(0, 0, Coord(0, 0, 0));
    for (const Coord& voxel : surface_) {
      for (int n = 0; n < 27; ++n) {
        const Coord near = voxel.offsetBy(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        if (!values_.isValueOn(near)) set(near, VoxelState::kProximity);
      }
    }
    grid_->pruneGrid();
    describe(*grid_, "states", volume, 0.5, file);  // Voxels are the cubes between lattice points.
  }
  [[nodiscard]] Int32Grid::Ptr grid() const { return grid_; }

 private:
  void set(const Coord& voxel, VoxelState state) { values_.setValue(voxel, static_cast<int>(state)); }

  void descend(std::uint32_t l, std::uint32_t node, const Coord& corner) {
    const OctreeLevel& level = octree_.level[l];
    const int side = 1 << (level.side_log2 - level.split);
    std::uint32_t child = level.first != nullptr ? level.first[node] : 0;
    for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
      const std::uint64_t surface = maskWord(level, OctreeMask::kSurface, node, w);
      for (std::uint64_t rest = maskWord(level, OctreeMask::kOccupied, node, w); rest != 0; rest &= rest - 1) {
        const int bit = std::countr_zero(rest);
        const ChildPlace k = childPlace(level.split, 64 * w + static_cast<std::uint32_t>(bit));
        const Coord at =
            corner.offsetBy(side * static_cast<int>(k.x), side * static_cast<int>(k.y), side * static_cast<int>(k.z));
        if ((surface >> bit & 1) == 0) {
          grid_->fill(openvdb::CoordBBox::createCube(at, side), static_cast<int>(VoxelState::kFull));
        } else if (level.first != nullptr) {
          descend(l + 1, child++, at);
        } else {
          set(at, VoxelState::kSurface);
          surface_.push_back(at);
        }
      }
    }
  }

  const OctreeView& octree_;
  Int32Grid::Ptr grid_ = Int32Grid::create(static_cast<int>(VoxelState::kEmpty));
  Int32Grid::Accessor values_;
  std::vector<Coord> surface_;
};

}  // namespace

Result<void> writeVdb(std::ostream& out, const VolumeView& volume, DistanceField* field, const std::string& source) {
  try {
    openvdb::initialize();
    openvdb::MetaMap meta;
    meta.insertMeta("hapticd_version", openvdb::StringMetadata(kVersion));
    meta.insertMeta("hapticd_volume_version", openvdb::Int32Metadata(HD_VOLUME_VERSION));
    meta.insertMeta("hapticd_source", openvdb::StringMetadata(source));
    Archive().put(out, {surfaceOf(volume, field, meta), States(volume, meta).grid()}, meta);
    out.flush();
  } catch (const openvdb::Exception& error) {
    return Error{ErrorCode::kInternal, "vdb", error.what(), {}};
  }
  if (!out) return Error{ErrorCode::kSystem, "vdb", "cannot be written", "is the disk full?"};
  return {};
}

void prepareVdb() {
  // OpenVDB's loops are TBB's, which starts its threads unless it may have but one.
  static const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  tbb::parallel_for(0, 1000, [](int) {});
  openvdb::initialize();
  const auto grid = FloatGrid::create(1);
  grid->getAccessor().setValue(Coord(0, 0, 0), 0);
  openvdb::tools::signedFloodFill(grid->tree(), false);
  std::stringstream out;
  Archive().put(out, {grid}, {});
}

}  // namespace hapticd
