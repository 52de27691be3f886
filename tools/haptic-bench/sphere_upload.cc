#include "tools/haptic-bench/sphere_upload.h"

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include "proto/snapshot.h"

namespace haptic_bench {

std::vector<std::byte> sphereUpload(std::uint32_t triangles, double radius) {
  // Two caps of 2 S triangles and S - 2 bands of 4 S: 4 S (S - 1) in all.
  std::uint32_t stacks = 3;
  while (4 * stacks * (stacks - 1) < triangles) ++stacks;
  const std::uint32_t slices = 2 * stacks;
  std::vector<std::array<float, 3>> vertices;
  const auto add = [&](double polar, double azimuth) {
    vertices.push_back({static_cast<float>(radius * std::sin(polar) * std::cos(azimuth)),
                        static_cast<float>(radius * std::sin(polar) * std::sin(azimuth)),
                        static_cast<float>(radius * std::cos(polar))});
  };
  add(0, 0);
  for (std::uint32_t i = 1; i < stacks; ++i) {
    for (std::uint32_t j = 0; j < slices; ++j) add(std::numbers::pi * i / stacks, 2 * std::numbers::pi * j / slices);
  }
  add(std::numbers::pi, 0);

  std::vector<std::array<std::uint32_t, 3>> faces;
  const auto at = [slices](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * slices + j % slices; };
  const auto south = static_cast<std::uint32_t>(vertices.size() - 1);
  for (std::uint32_t j = 0; j < slices; ++j) {
    faces.push_back({0, at(1, j), at(1, j + 1)});
    for (std::uint32_t i = 1; i + 1 < stacks; ++i) {
      faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    faces.push_back({at(stacks - 1, j), south, at(stacks - 1, j + 1)});
  }

  const hd_mesh_upload header{HD_UPLOAD_MAGIC, static_cast<std::uint32_t>(vertices.size()),
                              static_cast<std::uint32_t>(faces.size()), 0, 0};
  const std::size_t vertex_bytes = vertices.size() * sizeof vertices[0];
  const std::size_t face_bytes = faces.size() * sizeof faces[0];
  std::vector<std::byte> bytes(sizeof header + vertex_bytes + face_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, vertices.data(), vertex_bytes);
  std::memcpy(bytes.data() + sizeof header + vertex_bytes, faces.data(), face_bytes);
  return bytes;
}

}  // namespace haptic_bench
