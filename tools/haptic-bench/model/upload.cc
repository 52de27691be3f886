#include <cstring>

#include "proto/snapshot.h"
#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

std::vector<std::byte> upload(const Model& model) {
  const hd_mesh_upload header{HD_UPLOAD_MAGIC, static_cast<std::uint32_t>(model.vertices.size()),
                              static_cast<std::uint32_t>(model.triangles.size()), 0, 0};
  const std::size_t vertex_bytes = model.vertices.size() * sizeof model.vertices[0];
  const std::size_t triangle_bytes = model.triangles.size() * sizeof model.triangles[0];
  std::vector<std::byte> bytes(sizeof header + vertex_bytes + triangle_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, model.vertices.data(), vertex_bytes);
  std::memcpy(bytes.data() + sizeof header + vertex_bytes, model.triangles.data(), triangle_bytes);
  return bytes;
}

}  // namespace haptic_bench
