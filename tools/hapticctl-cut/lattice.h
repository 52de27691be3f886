/** @file
 * Points in rows, columns and layers, close together where it matters and farther apart elsewhere.
 */
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

namespace hapticctl_cut {

using Vec3 = Eigen::Vector3d;

/** A box along the axes. */
struct Box {
  Vec3 lower = Vec3::Constant(INFINITY), upper = Vec3::Constant(-INFINITY);
};

/** Lattice points: every combination of one plane of each axis. x fastest. */
struct Lattice {
  std::array<std::vector<double>, 3> plane;  ///< Rising.

  [[nodiscard]] std::size_t size(std::size_t axis) const { return plane[axis].size(); }
  [[nodiscard]] std::size_t count() const { return size(0) * size(1) * size(2); }
  [[nodiscard]] std::size_t index(std::size_t x, std::size_t y, std::size_t z) const {
    return x + size(0) * (y + size(1) * z);
  }
  [[nodiscard]] Vec3 at(std::size_t x, std::size_t y, std::size_t z) const {
    return {plane[0][x], plane[1][y], plane[2][z]};
  }
  /** Of a place between planes, in their numbers. */
  [[nodiscard]] double between(std::size_t axis, double number) const;
  /** The greater of the steps on both sides of each plane. */
  [[nodiscard]] std::vector<double> widths(std::size_t axis) const;
};

/**
 * About `whole` and three steps beyond: planes `fine` apart within `detail`, and ever farther apart outside, each step
 * by a fifth, up to `coarse`.
 */
[[nodiscard]] Lattice makeLattice(const Box& whole, const Box& detail, double fine, double coarse);

}  // namespace hapticctl_cut
