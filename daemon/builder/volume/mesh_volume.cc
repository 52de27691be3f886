#include "daemon/builder/volume/mesh_volume.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "daemon/builder/build.h"
#include "daemon/builder/volume/hole_fill.h"
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
          "close the holes, have them filled (--fill-holes), or weld with a larger distance"};
}

/** About the mesh; kInvalidArgument if building would take too much memory. */
Result<VolumeLattice> latticeOf(const MeshView& mesh, double voxel_m, const VolumeOptions& options) {
  Vec3 lower = mesh.vertex(0, 0), upper = lower;
  double area = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    for (int c = 0; c < 3; ++c) {
      lower = lower.cwiseMin(mesh.vertex(t, c));
      upper = upper.cwiseMax(mesh.vertex(t, c));
    }
    area += (mesh.vertex(t, 1) - mesh.vertex(t, 0)).cross(mesh.vertex(t, 2) - mesh.vertex(t, 0)).norm() / 2;
  }
  VolumeLattice lattice = latticeAbout(lower, upper, voxel_m, options.margin_voxels);
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  const double needed = bytesToBuild(lattice, area, options);
  const double most = limit.rlim_cur == RLIM_INFINITY ? static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                                                            static_cast<double>(::sysconf(_SC_PAGESIZE))
                                                      : static_cast<double>(limit.rlim_cur);
  if (needed > most) {
    return Error{ErrorCode::kInvalidArgument, "volume",
                 fmt::format("voxels of {:.4g} mm would take {:.1f} MB to build, more than the {:.1f} MB allowed",
                             voxel_m * 1e3, needed * 1e-6, most * 1e-6),
                 "choose a larger voxel, or raise builder.memory_mb"};
  }
  return lattice;
}

std::span<const Float3> verticesOf(const MeshView& mesh) {
  return {reinterpret_cast<const Float3*>(mesh.vertices), mesh.vertex_count};
}
std::span<const Index3> trianglesOf(const MeshView& mesh) {
  return {reinterpret_cast<const Index3*>(mesh.triangles), mesh.triangle_count};
}

Result<VolumeImage> writeWith(const MeshView& mesh, const VolumeLattice& lattice, const WindingTree* winding,
                              const VolumeOptions& options, BuildMonitor& monitor) {
  MeshField field(mesh, lattice, winding);
  VolumeSource source;
  source.lattice = lattice;
  source.field = &field;
  source.vertices = verticesOf(mesh);
  source.triangles = trianglesOf(mesh);
  source.options = options;
  return writeVolume(source, monitor);
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

/** A mesh with its tree, built here. */
struct BuiltMesh {
  BuiltSnapshot snapshot;
  Mapping mapping;
  MeshView view;
};

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

/** Of an open mesh: with its holes closed (hole_fill.h). */
Result<VolumeImage> writeFilled(const MeshView& mesh, const VolumeLattice& lattice, const VolumeOptions& options,
                                BuildMonitor& monitor) {
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
  BuiltMesh filled;
  if (const auto built = buildMesh(uploadOf(all_vertices, all_triangles), silent, filled); !built) return built.error();
  monitor.notes.push_back(fmt::format("holes: closed for the volume by {} triangles where the surface winds half about",
                                      fill->triangles.size()));
  const WindingTree winding(filled.view);
  return writeWith(filled.view, lattice, &winding, options, monitor);
}

}  // namespace

double bytesToBuild(const VolumeLattice& lattice, double area_m2, const VolumeOptions& options) {
  const double cells = static_cast<double>(lattice.cells[0]) * lattice.cells[1] * lattice.cells[2];
  const double in_voxels = area_m2 / (lattice.voxel * lattice.voxel), edge = HD_BRICK_EDGE;
  // A surface meets 1.5 cells per cell's area on average, and the band as many again as it is wide.
  const double bricks = std::min(cells, in_voxels / (edge * edge) * (1.5 + 2 * (options.band_voxels + 1) / edge));
  const double spacing = options.point_spacing_m > 0 ? options.point_spacing_m / lattice.voxel : 1;
  const double points = 1.5 * in_voxels / (spacing * spacing);
  const double samples = 9 * in_voxels;  // 56 bytes each, and 32 while they are sorted.
  return cells * 10 + bricks * 2 * 2 * HD_BRICK_STRIDE + points * (2 * 56 + 2 * 18) + samples * (56 + 32);
}

Result<VolumeImage> volumeOfMesh(const MeshView& mesh, double voxel_m, const VolumeOptions& options,
                                 BuildMonitor& monitor) {
  const bool closed = (mesh.flags & HD_MESH_CLOSED) != 0;
  if (!closed && !options.fill_holes) return openMesh(mesh);
  const auto lattice = latticeOf(mesh, voxel_m, options);
  if (!lattice) return lattice.error();
  return closed ? writeWith(mesh, *lattice, nullptr, options, monitor) : writeFilled(mesh, *lattice, options, monitor);
}

Result<VolumeImage> buildMeshVolume(std::span<const std::byte> upload, double voxel_m, const VolumeOptions& options,
                                    BuildMonitor& monitor) {
  BuiltMesh mesh;
  if (const auto built = buildMesh(upload, monitor, mesh); !built) return built.error();
  return volumeOfMesh(mesh.view, voxel_m, options, monitor);
}

Result<VolumeImage> buildMeshVolume(std::span<const Float3> vertices, std::span<const Index3> triangles, double voxel_m,
                                    const VolumeOptions& options, BuildMonitor& monitor) {
  return buildMeshVolume(uploadOf(vertices, triangles), voxel_m, options, monitor);
}

}  // namespace hapticd
