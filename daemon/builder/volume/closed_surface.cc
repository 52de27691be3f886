#include "daemon/builder/volume/closed_surface.h"

#include <fmt/core.h>

#include <cstring>

#include "daemon/builder/volume/hole_fill.h"
#include "daemon/builder/volume/volume_writer.h"

namespace hapticd {
namespace {

/** Six times what the triangles enclose with the middle of their box; negative: they look inward. */
double enclosedBy(const MeshView& mesh, const VolumeLattice& lattice) {
  const Vec3 middle = lattice.at({static_cast<std::int32_t>(lattice.cells[0] * HD_BRICK_EDGE / 2),
                                  static_cast<std::int32_t>(lattice.cells[1] * HD_BRICK_EDGE / 2),
                                  static_cast<std::int32_t>(lattice.cells[2] * HD_BRICK_EDGE / 2)});
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t)
    sum += (mesh.vertex(t, 0) - middle).dot((mesh.vertex(t, 1) - middle).cross(mesh.vertex(t, 2) - middle));
  return sum;
}

}  // namespace

std::span<const Float3> verticesOf(const MeshView& mesh) {
  return {reinterpret_cast<const Float3*>(mesh.vertices), mesh.vertex_count};
}
std::span<const Index3> trianglesOf(const MeshView& mesh) {
  return {reinterpret_cast<const Index3*>(mesh.triangles), mesh.triangle_count};
}

std::vector<std::byte> uploadOf(std::span<const Float3> vertices, std::span<const Index3> triangles) {
  hd_mesh_upload header{};
  header.magic = HD_UPLOAD_MAGIC;
  header.vertex_count = static_cast<std::uint32_t>(vertices.size());
  header.triangle_count = static_cast<std::uint32_t>(triangles.size());
  std::vector<std::byte> upload(sizeof header + vertices.size_bytes() + triangles.size_bytes());
  std::memcpy(upload.data(), &header, sizeof header);
  if (!vertices.empty()) std::memcpy(upload.data() + sizeof header, vertices.data(), vertices.size_bytes());
  if (!triangles.empty())
    std::memcpy(upload.data() + sizeof header + vertices.size_bytes(), triangles.data(), triangles.size_bytes());
  return upload;
}

Result<void> buildMesh(std::span<const std::byte> upload, BuildMonitor& monitor, BuiltMesh& out) {
  // The tree takes little of the time; its progress is not shown.
  BuildMonitor quiet;
  quiet.progress = [&](float, const char* stage) { return monitor.progress(0, stage); };
  auto built = buildSnapshot(upload, quiet);
  monitor.notes.insert(monitor.notes.end(), quiet.notes.begin(), quiet.notes.end());
  if (!built) return built.error();
  out.snapshot = std::move(*built);
  auto mapping = out.snapshot.memfd.map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  out.mapping = std::move(*mapping);
  const auto view = validateSnapshot(out.mapping.bytes());
  if (!view) return view.error();
  out.view = *view;
  return {};
}

Result<std::unique_ptr<ClosedSurface>> closeSurface(const MeshView& mesh, const VolumeLattice& lattice,
                                                    BuildMonitor& monitor) {
  auto surface = std::make_unique<ClosedSurface>();
  surface->mesh = &mesh;
  if ((mesh.flags & HD_MESH_CLOSED) != 0) return surface;
  if (const auto checked = checkLattice(lattice); !checked) return checked.error();  // Before its voxels are walked.
  const auto vertices = verticesOf(mesh);
  const auto triangles = trianglesOf(mesh);
  std::vector<Float3> all_vertices(vertices.begin(), vertices.end());
  std::vector<Index3> all_triangles(triangles.begin(), triangles.end());
  BuildMonitor silent;  // What was repaired is told already.
  silent.progress = monitor.progress;
  BuiltMesh turned;
  const MeshView* outward = &mesh;
  if (enclosedBy(mesh, lattice) < 0) {
    for (Index3& t : all_triangles) std::swap(t[1], t[2]);
    if (const auto built = buildMesh(uploadOf(all_vertices, all_triangles), silent, turned); !built)
      return built.error();
    outward = &turned.view;
    monitor.notes.emplace_back("holes: the open surface looks inward; its volume is made as if it looked outward");
  }
  const auto fill = fillHoles(*outward, WindingTree(*outward), lattice, monitor);
  if (!fill) return fill.error();
  const auto base = static_cast<std::uint32_t>(all_vertices.size());
  all_vertices.insert(all_vertices.end(), fill->vertices.begin(), fill->vertices.end());
  for (const Index3& t : fill->triangles) all_triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  if (const auto built = buildMesh(uploadOf(all_vertices, all_triangles), silent, surface->own); !built)
    return built.error();
  monitor.notes.push_back(fmt::format("holes: closed for the volume by {} triangles where the surface winds half about",
                                      fill->triangles.size()));
  surface->mesh = &surface->own.view;
  surface->winding.emplace(surface->own.view);
  return surface;
}

}  // namespace hapticd
