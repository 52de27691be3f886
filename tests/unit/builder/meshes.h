/** @file
 * Meshes for tests: shapes with known figures, and uploads made of them.
 */
#pragma once

#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <vector>

#include "daemon/builder/build.h"
#include "tests/support/seeds.h"

namespace hapticd::test {

struct UploadMesh {
  std::vector<Float3> vertices;
  std::vector<Index3> triangles;

  /** Appends another mesh, moved and scaled. */
  UploadMesh& add(const UploadMesh& other, Float3 shift = {0, 0, 0}, float scale = 1) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    for (const Float3& p : other.vertices)
      vertices.push_back({p[0] * scale + shift[0], p[1] * scale + shift[1], p[2] * scale + shift[2]});
    for (const Index3& t : other.triangles) triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    return *this;
  }
  UploadMesh& flipAll() {
    for (Index3& t : triangles) std::swap(t[1], t[2]);
    return *this;
  }
  /** As an STL file gives it: three vertices of its own for each triangle. */
  [[nodiscard]] UploadMesh soup() const {
    UploadMesh out;
    for (const Index3& t : triangles) {
      const auto base = static_cast<std::uint32_t>(out.vertices.size());
      for (const std::uint32_t v : t) out.vertices.push_back(vertices[v]);
      out.triangles.push_back({base, base + 1, base + 2});
    }
    return out;
  }
};

/** A torus about z, radii 50 mm and 20 mm: closed, outward, 2 * n * m triangles, n * m vertices. */
inline UploadMesh torus(std::uint32_t n, std::uint32_t m) {
  UploadMesh mesh;
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j) {
      const double a = 2 * std::numbers::pi * i / n, b = 2 * std::numbers::pi * j / m, r = 0.05 + 0.02 * std::cos(b);
      mesh.vertices.push_back({static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)),
                               static_cast<float>(0.02 * std::sin(b))});
    }
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < m; ++j) {
      const std::uint32_t a = i * m + j, b = (i + 1) % n * m + j, c = (i + 1) % n * m + (j + 1) % m,
                          d = i * m + (j + 1) % m;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

/** The cube from -1 to 1 [cm], 12 triangles, outward. */
inline UploadMesh cube() {
  UploadMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        {(i & 1) != 0 ? 0.01f : -0.01f, (i & 2) != 0 ? 0.01f : -0.01f, (i & 4) != 0 ? 0.01f : -0.01f});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/** A bumpy open square of n by n cells, 10 cm wide, looking along +z. */
inline UploadMesh terrain(std::uint32_t n, unsigned seed) {
  UploadMesh mesh;
  std::mt19937 random(seedOf(seed));
  std::uniform_real_distribution<float> height(0, 0.002f);
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j)
      mesh.vertices.push_back({0.1f * static_cast<float>(i) / static_cast<float>(n),
                               0.1f * static_cast<float>(j) / static_cast<float>(n), height(random)});
  const auto at = [n](std::uint32_t i, std::uint32_t j) { return i * (n + 1) + j; };
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

inline std::vector<std::byte> upload(const UploadMesh& mesh, std::uint32_t flags = 0, float weld_m = 0) {
  hd_mesh_upload header{};
  header.magic = HD_UPLOAD_MAGIC;
  header.vertex_count = static_cast<std::uint32_t>(mesh.vertices.size());
  header.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  header.flags = flags;
  header.weld_m = weld_m;
  const std::size_t vertex_bytes = mesh.vertices.size() * sizeof(Float3);
  const std::size_t triangle_bytes = mesh.triangles.size() * sizeof(Index3);
  std::vector<std::byte> bytes(sizeof header + vertex_bytes + triangle_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  if (vertex_bytes != 0) std::memcpy(bytes.data() + sizeof header, mesh.vertices.data(), vertex_bytes);
  if (triangle_bytes != 0)
    std::memcpy(bytes.data() + sizeof header + vertex_bytes, mesh.triangles.data(), triangle_bytes);
  return bytes;
}

/** The upload of a mesh with the request for a volume behind it. */
inline std::vector<std::byte> volumeUpload(const UploadMesh& mesh, float voxel_m, std::uint32_t flags = 0) {
  std::vector<std::byte> bytes = upload(mesh, flags | HD_UPLOAD_VOLUME);
  hd_volume_request request{};
  request.voxel_m = voxel_m;
  const auto* const first = reinterpret_cast<const std::byte*>(&request);
  bytes.insert(bytes.end(), first, first + sizeof request);
  return bytes;
}

}  // namespace hapticd::test
