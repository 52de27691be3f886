/** @file
 * The same mesh in other words, to the bit: its triangles in another order, or each cut in four; and round meshes.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd::test {

/** Vertices are put onto whole steps of that [m], so that the middle of an edge is a float too. */
inline constexpr double kVertexStep = 0x1p-17;

inline void toSteps(TestMesh& mesh) {
  for (auto& v : mesh.vertices) {
    for (float& x : v) x = static_cast<float>(kVertexStep * std::round(x / kVertexStep));
  }
}

/** Each triangle cut at the middles of its edges. Vertices stand on steps. */
inline TestMesh inFour(const TestMesh& mesh) {
  TestMesh out;
  out.flags = mesh.flags;
  out.vertices = mesh.vertices;
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> known;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [place, is_new] = known.try_emplace({std::min(a, b), std::max(a, b)}, 0);
    if (is_new) {
      const auto &p = mesh.vertices[a], &q = mesh.vertices[b];
      place->second = out.addVertex({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
    }
    return place->second;
  };
  for (const auto& t : mesh.triangles) {
    const std::uint32_t m[3] = {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])};
    out.addTriangle(t[0], m[0], m[2]);
    out.addTriangle(m[0], t[1], m[1]);
    out.addTriangle(m[2], m[1], t[2]);
    out.addTriangle(m[0], m[1], m[2]);
  }
  return out;
}

/** Triangles and their corners in another order. */
inline void shuffle(TestMesh& mesh, std::uint32_t seed) {
  Random random(seed);
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    std::swap(mesh.triangles[i], mesh.triangles[random.below(i + 1)]);
    std::rotate(mesh.triangles[i].begin(), mesh.triangles[i].begin() + random.below(3), mesh.triangles[i].end());
  }
}

/** On the plane z = 0, of n sides. */
inline TestMesh coneMesh(double radius, double height, std::uint32_t n) {
  TestMesh m;
  m.flags = HD_MESH_CLOSED;
  m.addVertex({0, 0, height});
  m.addVertex(Vec3::Zero());
  for (std::uint32_t i = 0; i < n; ++i) {
    const double phi = 2 * M_PI * i / n;
    m.addVertex(radius * Vec3(std::cos(phi), std::sin(phi), 0));
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    m.addTriangle(0, 2 + i, 2 + (i + 1) % n);
    m.addTriangle(1, 2 + (i + 1) % n, 2 + i);
  }
  return m;
}

/** About z, a tube of `thick` about a circle of `wide`, of n x n quads. */
inline TestMesh torusMesh(double wide, double thick, std::uint32_t n) {
  TestMesh m;
  m.flags = HD_MESH_CLOSED;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const double u = 2 * M_PI * i / n, v = 2 * M_PI * j / n, r = wide + thick * std::cos(v);
      m.addVertex({r * std::cos(u), r * std::sin(u), thick * std::sin(v)});
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % n * n + j % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < n; ++j) m.addQuad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  }
  return m;
}

}  // namespace hapticd::test
