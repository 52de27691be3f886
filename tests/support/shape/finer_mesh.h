/** @file
 * The same solid in many facets.
 */
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>

#include "tests/support/shape/test_mesh.h"

namespace hapticd::test {

/** Of each triangle cells^2, at that pose: rounding leaves those of a flat side not quite in one plane. */
inline TestMesh finer(const TestMesh& mesh, int cells, const Pose& X) {
  constexpr double kApart = 1e-8;  // [m]
  TestMesh out;
  out.flags = mesh.flags;
  std::map<std::tuple<long, long, long>, std::uint32_t> known;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](int i) {
      const auto& v = mesh.vertices[triangle[i]];
      return Vec3(v[0], v[1], v[2]);
    };
    const auto at = [&](int i, int j) {
      const Vec3 x = corner(0) + (i * (corner(1) - corner(0)) + j * (corner(2) - corner(0))) / cells;
      const Vec3 grid = x / kApart;
      const auto [place, is_new] =
          known.try_emplace({std::lround(grid.x()), std::lround(grid.y()), std::lround(grid.z())}, 0);
      if (is_new) place->second = out.addVertex(X * x);
      return place->second;
    };
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells - i; ++j) {
        out.addTriangle(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j < cells - 1) out.addTriangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  return out;
}

}  // namespace hapticd::test
