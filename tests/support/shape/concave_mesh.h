/** @file
 * Closed meshes with edges that point inward, or sharply outward.
 */
#pragma once

#include <array>
#include <map>
#include <vector>

#include "tests/support/shape/test_mesh.h"

namespace hapticd::test {

/** Of the cells between those coordinates, ascending, the ones that isFull(i, j, k); turned by q. */
template <class IsFull>
TestMesh meshOfCells(const std::array<std::vector<double>, 3>& at, const Quat& q, const IsFull& isFull) {
  using Place = std::array<int, 3>;
  TestMesh mesh;
  mesh.flags = HD_MESH_CLOSED;
  std::map<Place, std::uint32_t> known;
  const auto vertex = [&](const Place& i) {
    const auto [place, is_new] = known.try_emplace(i, 0);
    if (is_new) place->second = mesh.addVertex(q * Vec3(at[0][i[0]], at[1][i[1]], at[2][i[2]]));
    return place->second;
  };
  const auto full = [&](const Place& cell) {
    for (int axis = 0; axis < 3; ++axis) {
      if (cell[axis] < 0 || cell[axis] + 1 >= static_cast<int>(at[axis].size())) return false;
    }
    return isFull(cell[0], cell[1], cell[2]);
  };
  const auto addSide = [&](const Place& cell, int axis, int side) {
    Place beside = cell;
    beside[axis] += 2 * side - 1;
    if (full(beside)) return;
    std::array<Place, 4> corner;
    corner.fill(cell);
    for (int i = 0; i < 4; ++i) {
      corner[i][axis] += side;
      corner[i][(axis + 1) % 3] += i == 1 || i == 2 ? 1 : 0;
      corner[i][(axis + 2) % 3] += i >= 2 ? 1 : 0;
    }
    const int first = side == 1 ? 1 : 3;
    mesh.addQuad(vertex(corner[0]), vertex(corner[first]), vertex(corner[2]), vertex(corner[4 - first]));
  };
  for (int i = 0; i + 1 < static_cast<int>(at[0].size()); ++i) {
    for (int j = 0; j + 1 < static_cast<int>(at[1].size()); ++j) {
      for (int k = 0; k + 1 < static_cast<int>(at[2].size()); ++k) {
        if (!full({i, j, k})) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (const int side : {0, 1}) addSide({i, j, k}, axis, side);
        }
      }
    }
  }
  return mesh;
}

/** What has that outline, anticlockwise in x and z, from -half to half along y; turned by q. */
inline TestMesh prismMesh(const std::vector<std::array<double, 2>>& outline, double half, const Quat& q) {
  TestMesh mesh;
  mesh.flags = HD_MESH_CLOSED;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double y : {half, -half}) {
    for (const auto& [x, z] : outline) mesh.addVertex(q * Vec3(x, y, z));
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.addQuad(i, next, n + next, n + i);
    if (i >= 2) {  // The outline is seen whole from its first corner.
      mesh.addTriangle(0, i, i - 1);
      mesh.addTriangle(n, n + i - 1, n + i);
    }
  }
  return mesh;
}

/** On a square half so wide; turned by q. */
inline TestMesh pyramidMesh(double half, double top, double bottom, const Quat& q) {
  TestMesh mesh;
  mesh.flags = HD_MESH_CLOSED;
  for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}})
    mesh.addVertex(q * Vec3(x, y, bottom));
  mesh.addVertex(q * Vec3(0, 0, top));
  mesh.addQuad(0, 3, 2, 1);
  for (std::uint32_t i = 0; i < 4; ++i) mesh.addTriangle(i, (i + 1) % 4, 4);
  return mesh;
}

}  // namespace hapticd::test
