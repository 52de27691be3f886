#include "daemon/builder/volume/field_builder.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr std::int32_t kEdge = HD_BRICK_EDGE;
constexpr double kFullScale = 32767;

std::int16_t quantised(double value, double step) {
  return static_cast<std::int16_t>(std::lround(std::clamp(value / step, -kFullScale, kFullScale)));
}

std::uint64_t morton(const Lattice3& cell) {
  std::uint64_t key = 0;
  for (int bit = 0; bit < 16; ++bit) {
    for (std::size_t k = 0; k < 3; ++k)
      key |= (static_cast<std::uint64_t>(cell[k]) >> bit & 1) << (3 * bit + static_cast<int>(k));
  }
  return key;
}

struct Candidate {
  std::uint64_t order;
  Lattice3 cell;
};

std::size_t cornerIndex(const VolumeLattice& lattice, const Lattice3& c) {
  const std::size_t nx = lattice.cells[0] + 1, ny = lattice.cells[1] + 1;
  return static_cast<std::size_t>(c[0]) + nx * (static_cast<std::size_t>(c[1]) + ny * static_cast<std::size_t>(c[2]));
}

std::size_t cellIndex(const VolumeLattice& lattice, const Lattice3& c) {
  const std::size_t nx = lattice.cells[0], ny = lattice.cells[1];
  return static_cast<std::size_t>(c[0]) + nx * (static_cast<std::size_t>(c[1]) + ny * static_cast<std::size_t>(c[2]));
}

/** Calls visit(c) for 0 <= c < n; false stops. */
template <class Visit>
bool forEach(const std::array<std::uint32_t, 3>& n, Visit&& visit) {
  Lattice3 c{};
  for (c[2] = 0; c[2] < static_cast<std::int32_t>(n[2]); ++c[2]) {
    for (c[1] = 0; c[1] < static_cast<std::int32_t>(n[1]); ++c[1]) {
      for (c[0] = 0; c[0] < static_cast<std::int32_t>(n[0]); ++c[0])
        if (!visit(c)) return false;
    }
  }
  return true;
}

Lattice3 times(const Lattice3& c, std::int32_t by, std::int32_t plus = 0) {
  return {c[0] * by + plus, c[1] * by + plus, c[2] * by + plus};
}

}  // namespace

bool BuiltField::isInside(const VolumeLattice& lattice, const Lattice3& point) const {
  Lattice3 cell, local;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto most = static_cast<std::int32_t>(lattice.cells[k]);
    if (point[k] < 0 || point[k] > most * kEdge) return false;
    cell[k] = std::min(point[k] / kEdge, most - 1);
    local[k] = point[k] - cell[k] * kEdge;
  }
  const std::uint32_t brick = cells[cellIndex(lattice, cell)];
  if (brick != HD_NO_INDEX) {
    const std::int32_t n = HD_BRICK_SAMPLES, at = local[0] + n * (local[1] + n * local[2]);
    return bricks[std::size_t{HD_BRICK_STRIDE} * brick + static_cast<std::size_t>(at)] < 0;
  }
  return coarse[cornerIndex(lattice, cell)] < 0;  // No surface crosses the cell: one corner speaks for it.
}

BuiltField buildField(const VolumeLattice& lattice, DistanceField& field, double band_m, BuildMonitor& monitor,
                      float begin, float end) {
  BuiltField built;
  const float half = begin + (end - begin) * 0.1f;
  std::array<std::uint32_t, 3> corners = lattice.cells;
  for (std::uint32_t& n : corners) ++n;
  std::vector<float> coarse;
  double most = lattice.voxel;
  bool go = forEach(corners, [&](const Lattice3& c) {
    coarse.push_back(field.at(times(c, kEdge)));
    most = std::max<double>(most, std::abs(coarse.back()));
    return c[0] != 0 ||
           monitor.progress(begin + (half - begin) * static_cast<float>(c[2]) / static_cast<float>(corners[2]),
                            "measuring the space");
  });
  if (!go) return {};
  built.coarse_step = static_cast<float>(most / kFullScale);
  for (const float d : coarse) built.coarse.push_back(quantised(d, built.coarse_step));

  // Whose cell the surface can be near to: its middle tells, for no point of the cell is farther than half a diagonal.
  const double half_diagonal = std::sqrt(3.0) / 2 * kEdge * lattice.voxel;
  std::vector<Candidate> candidates;
  go = forEach(lattice.cells, [&](const Lattice3& c) {
    if (std::abs(field.at(times(c, kEdge, kEdge / 2))) <= band_m + half_diagonal) candidates.push_back({morton(c), c});
    return c[0] != 0 || monitor.progress(half, "finding the surface");
  });
  if (!go) return {};
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.order < b.order; });

  // No value of a kept brick exceeds the band and the brick's diagonal.
  const double half_voxel = half_diagonal / kEdge;
  built.fine_step = static_cast<float>((band_m + half_voxel + 2 * half_diagonal) / kFullScale);
  built.cells.assign(lattice.cellCount(), HD_NO_INDEX);
  std::array<float, HD_BRICK_VALUES> values;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (i % 16 == 0 &&
        !monitor.progress(half + (end - half) * static_cast<float>(i) / static_cast<float>(candidates.size()),
                          "filling bricks"))
      return {};
    field.fill(times(candidates[i].cell, kEdge), values);
    float least = values[0];
    for (const float v : values) least = std::abs(v) < std::abs(least) ? v : least;
    if (std::abs(least) > band_m + half_voxel) continue;  // Some lattice point is so near to the cell's nearest point.
    built.cells[cellIndex(lattice, candidates[i].cell)] = built.brick_count++;
    for (const float v : values) built.bricks.push_back(quantised(v, built.fine_step));
    built.bricks.resize(std::size_t{HD_BRICK_STRIDE} * built.brick_count, 0);
  }
  return built;
}

}  // namespace hapticd
