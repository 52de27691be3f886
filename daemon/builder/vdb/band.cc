#include "daemon/builder/vdb/band.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hapticd {
namespace {

constexpr std::int32_t kEdge = HD_BRICK_EDGE;
using Distances = std::array<float, HD_BRICK_VALUES>;

class Band {
 public:
  Band(const VolumeView& volume, DistanceField* field, double width_m, const BandVisit& visit)
      : volume_(volume), field_(field), width_(width_m), visit_(visit) {}

  void run() {
    Lattice3 c;
    for (c[2] = 0; c[2] < count(2); ++c[2]) {
      for (c[1] = 0; c[1] < count(1); ++c[1])
        for (c[0] = 0; c[0] < count(0); ++c[0]) cell(c);
    }
  }

 private:
  [[nodiscard]] std::int32_t count(std::size_t k) const { return static_cast<std::int32_t>(volume_.cells[k]); }
  /** Of a cell, or with more = 1 of a corner. */
  [[nodiscard]] std::size_t index(const Lattice3& c, std::size_t more) const {
    return static_cast<std::size_t>(c[0]) +
           (volume_.cells[0] + more) *
               (static_cast<std::size_t>(c[1]) + (volume_.cells[1] + more) * static_cast<std::size_t>(c[2]));
  }

  void cell(const Lattice3& c) {
    const Lattice3 first{c[0] * kEdge, c[1] * kEdge, c[2] * kEdge};
    const std::uint32_t brick = volume_.cell[index(c, 0)];
    Distances distances;
    if (brick != HD_NO_INDEX) {
      const std::int16_t* sample = volume_.bricks + std::size_t{HD_BRICK_STRIDE} * brick;
      for (float& d : distances) d = static_cast<float>(*sample++) * volume_.fine_step;
    } else {
      if (field_ == nullptr || !mayBeNear(c, first)) return;
      field_->fill(first, distances);
    }
    visit_(first, distances);
  }

  /** No point of a cell is farther from its nearest corner, or from its middle, than half its diagonal. */
  [[nodiscard]] bool mayBeNear(const Lattice3& c, const Lattice3& first) const {
    const double half_diagonal = std::sqrt(3.0) / 2 * kEdge * static_cast<double>(volume_.voxel);
    double least = INFINITY;
    for (int n = 0; n < 8; ++n) {
      const Lattice3 corner{c[0] + (n & 1), c[1] + (n >> 1 & 1), c[2] + (n >> 2)};
      const double distance = static_cast<double>(volume_.coarse[index(corner, 1)]) * double{volume_.coarse_step};
      least = std::min(least, std::abs(distance));
    }
    if (least > width_ + half_diagonal + double{volume_.coarse_step}) return false;
    const Lattice3 middle{first[0] + kEdge / 2, first[1] + kEdge / 2, first[2] + kEdge / 2};
    return std::abs(double{field_->at(middle)}) <= width_ + half_diagonal;
  }

  const VolumeView& volume_;
  DistanceField* field_;
  double width_;
  const BandVisit& visit_;
};

}  // namespace

VolumeLattice latticeOf(const VolumeView& volume) {
  VolumeLattice lattice;
  lattice.voxel = double{volume.voxel};
  lattice.origin = volume.originPoint();
  lattice.cells = volume.cells;
  return lattice;
}

void visitBand(const VolumeView& volume, DistanceField* field, double width_m, const BandVisit& visit) {
  Band(volume, field, width_m, visit).run();
}

}  // namespace hapticd
