#include "rt/volume/distance.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr double kCellHalfDiagonal = 0.8660254037844386;  // sqrt(3) / 2

/** Eight corner values and the place between them, 0 to 1 on each axis: value and gradient per side. */
struct Trilinear {
  double value;
  Vec3 slope;
};

Trilinear interpolate(const std::int16_t* v, std::size_t dy, std::size_t dz, const Vec3& t) HD_RT {
  const double c000 = v[0], c100 = v[1], c010 = v[dy], c110 = v[dy + 1];
  const double c001 = v[dz], c101 = v[dz + 1], c011 = v[dz + dy], c111 = v[dz + dy + 1];
  const double x00 = c000 + t.x() * (c100 - c000), x10 = c010 + t.x() * (c110 - c010);
  const double x01 = c001 + t.x() * (c101 - c001), x11 = c011 + t.x() * (c111 - c011);
  const double y0 = x00 + t.y() * (x10 - x00), y1 = x01 + t.y() * (x11 - x01);
  const double sx0 = (1 - t.y()) * (c100 - c000) + t.y() * (c110 - c010);
  const double sx1 = (1 - t.y()) * (c101 - c001) + t.y() * (c111 - c011);
  return {y0 + t.z() * (y1 - y0),
          {sx0 + t.z() * (sx1 - sx0), (1 - t.z()) * (x10 - x00) + t.z() * (x11 - x01), y1 - y0}};
}

}  // namespace

DistanceSample distanceAt(const VolumeView& volume, const Vec3& x_O) HD_RT {
  const double side = volume.voxel, edge = HD_BRICK_EDGE;
  const Vec3 u = (x_O - volume.originPoint()) / side;
  Vec3 inside = u, local;
  std::size_t at[3];
  for (int k = 0; k < 3; ++k) {
    inside[k] = std::clamp(u[k], 0.0, edge * volume.cells[k]);
    at[k] = std::min<std::size_t>(static_cast<std::size_t>(inside[k] / edge), volume.cells[k] - 1);
    local[k] = inside[k] - edge * static_cast<double>(at[k]);
  }
  const std::size_t nx = volume.cells[0], ny = volume.cells[1];
  const std::uint32_t brick = volume.cell[at[0] + nx * (at[1] + ny * at[2])];
  DistanceSample sample;
  sample.fine = brick != HD_NO_INDEX;
  if (sample.fine) {
    constexpr std::size_t kSide = HD_BRICK_SAMPLES;
    std::size_t i[3];
    Vec3 t;
    for (int k = 0; k < 3; ++k) {
      i[k] = std::min<std::size_t>(static_cast<std::size_t>(local[k]), HD_BRICK_EDGE - 1);
      t[k] = local[k] - static_cast<double>(i[k]);
    }
    const auto got =
        interpolate(volume.bricks + std::size_t{HD_BRICK_STRIDE} * brick + i[0] + kSide * (i[1] + kSide * i[2]), kSide,
                    kSide * kSide, t);
    sample.value = got.value * volume.fine_step;
    sample.gradient = got.slope * (volume.fine_step / side);
    sample.error = kCellHalfDiagonal * side + volume.fine_step / 2;
  } else {
    const auto got = interpolate(volume.coarse + at[0] + (nx + 1) * (at[1] + (ny + 1) * at[2]), nx + 1,
                                 (nx + 1) * (ny + 1), local / edge);
    sample.value = got.value * volume.coarse_step;
    sample.gradient = got.slope * (volume.coarse_step / (side * edge));
    sample.error = kCellHalfDiagonal * side * edge + volume.coarse_step / 2;
  }
  const Vec3 beyond = (u - inside) * side;
  if (beyond.squaredNorm() > 0) {
    // All surface lies in the lattice's box, seen from its nearest point at no acute angle: Pythagoras bounds from
    // below. The triangle inequality bounds from above, so the error grows by the difference.
    const double here = std::max(sample.value, 0.0), away = beyond.norm();
    const double value = std::hypot(here, away);
    const Vec3 g = sample.gradient * here + beyond;  // The way to the box's point, then on from there.
    sample.error += here + away - value;
    sample.value = value;
    sample.gradient = g / value;
    sample.fine = false;
  }
  return sample;
}

}  // namespace hapticd
