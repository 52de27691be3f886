#include "daemon/builder/volume/mesh_volume.h"

#include <fmt/core.h>

#include <cmath>
#include <cstring>

#include "daemon/builder/build.h"
#include "daemon/builder/volume/mesh_field.h"

namespace hapticd {
namespace {

Error openMesh(const MeshView& mesh) {
  std::size_t borders = 0;
  Vec3 where = Vec3::Zero();
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    for (int e = 0; e < 3; ++e) {
      if (mesh.neighbours[t][e] != HD_NO_INDEX) continue;
      if (borders++ == 0) where = (mesh.vertex(t, e) + mesh.vertex(t, (e + 1) % 3)) / 2;
    }
  }
  return {ErrorCode::kBadMesh, fmt::format("edge at {:.6g} {:.6g} {:.6g} m", where.x(), where.y(), where.z()),
          fmt::format("the surface is open there; it has {} such edges", borders),
          "close the holes, or weld with a larger distance"};
}

}  // namespace

Result<VolumeImage> buildMeshVolume(std::span<const std::byte> upload, double voxel_m, const VolumeOptions& options,
                                    BuildMonitor& monitor) {
  // The tree takes little of the time; its progress is not shown.
  BuildMonitor quiet;
  quiet.progress = [&](float, const char* stage) { return monitor.progress(0, stage); };
  const auto built = buildSnapshot(upload, quiet);
  monitor.notes.insert(monitor.notes.end(), quiet.notes.begin(), quiet.notes.end());
  if (!built) return built.error();
  const auto mapping = built->memfd.map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  const auto mesh = validateSnapshot(mapping->bytes());
  if (!mesh) return mesh.error();
  if ((mesh->flags & HD_MESH_CLOSED) == 0) return openMesh(*mesh);

  const auto& header = *mapping->as<hd_snapshot_header>();
  const Vec3 lower(header.lower[0], header.lower[1], header.lower[2]);
  const Vec3 upper(header.upper[0], header.upper[1], header.upper[2]);
  VolumeSource source;
  source.lattice = latticeAbout(lower, upper, voxel_m);
  MeshField field(*mesh, source.lattice);
  source.field = &field;
  source.vertices = {reinterpret_cast<const Float3*>(mesh->vertices), mesh->vertex_count};
  source.triangles = {reinterpret_cast<const Index3*>(mesh->triangles), mesh->triangle_count};
  source.options = options;
  return writeVolume(source, monitor);
}

Result<VolumeImage> buildMeshVolume(std::span<const Float3> vertices, std::span<const Index3> triangles, double voxel_m,
                                    const VolumeOptions& options, BuildMonitor& monitor) {
  hd_mesh_upload header{};
  header.magic = HD_UPLOAD_MAGIC;
  header.vertex_count = static_cast<std::uint32_t>(vertices.size());
  header.triangle_count = static_cast<std::uint32_t>(triangles.size());
  std::vector<std::byte> upload(sizeof header + vertices.size_bytes() + triangles.size_bytes());
  std::memcpy(upload.data(), &header, sizeof header);
  if (!vertices.empty()) std::memcpy(upload.data() + sizeof header, vertices.data(), vertices.size_bytes());
  if (!triangles.empty())
    std::memcpy(upload.data() + sizeof header + vertices.size_bytes(), triangles.data(), triangles.size_bytes());
  return buildMeshVolume(upload, voxel_m, options, monitor);
}

}  // namespace hapticd
