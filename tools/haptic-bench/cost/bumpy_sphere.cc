#include "tools/haptic-bench/cost/bumpy_sphere.h"

#include <cmath>

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {
namespace {

constexpr double kRadius = 0.05;    // [m]
constexpr double kHeight = 0.5e-3;  // Of the waves [m].
constexpr double kBumps = 30;       // Radians of a wave per radian of the sphere: 10 mm long.

/** One face of the octahedron; `sign` gives its octant. Corners of neighbours are equal to the bit. */
void addOctant(std::uint32_t n, const hapticd::Vec3& sign, Model& model) {
  const auto base = static_cast<std::uint32_t>(model.vertices.size());
  for (std::uint32_t i = 0; i <= n; ++i) {
    for (std::uint32_t j = 0; i + j <= n; ++j) {
      const hapticd::Vec3 at(i, j, n - i - j);
      const hapticd::Vec3 u = at.cwiseProduct(sign).normalized();
      model.addVertex(bumpyRadius(u) * u);
    }
  }
  const auto number = [&](std::uint32_t i, std::uint32_t j) { return base + i * (n + 1) - i * (i - 1) / 2 + j; };
  const bool flip = sign.prod() < 0;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    model.triangles.push_back({a, flip ? c : b, flip ? b : c});
  };
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; i + j < n; ++j) {
      add(number(i, j), number(i + 1, j), number(i, j + 1));
      if (i + j + 2 <= n) add(number(i + 1, j), number(i + 1, j + 1), number(i, j + 1));
    }
  }
}

/** Into how many parts an edge of the octahedron is divided. */
std::uint32_t edgeParts(std::uint32_t triangles) {
  std::uint32_t n = 1;
  while (8 * n * n < triangles) ++n;
  return n;
}

}  // namespace

double bumpyRadius(const hapticd::Vec3& u) {
  return kRadius + kHeight * std::sin(kBumps * u.x()) * std::sin(kBumps * u.y()) * std::sin(kBumps * u.z());
}

std::uint32_t bumpySphereTriangles(std::uint32_t triangles) {
  const std::uint32_t n = edgeParts(triangles);
  return 8 * n * n;
}

std::vector<std::byte> bumpySphereUpload(std::uint32_t triangles) {
  const std::uint32_t n = edgeParts(triangles);
  Model model;
  for (int octant = 0; octant < 8; ++octant)
    addOctant(n, {octant & 1 ? -1.0 : 1.0, octant & 2 ? -1.0 : 1.0, octant & 4 ? -1.0 : 1.0}, model);
  return upload(model);
}

}  // namespace haptic_bench
