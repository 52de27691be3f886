#include "daemon/builder/volume/mesh_volume.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>

#include "daemon/builder/volume/closed_surface.h"
#include "daemon/builder/volume/mesh_field.h"
#include "daemon/builder/volume/surface_points.h"

namespace hapticd {
namespace {

/** A border by its ends, in rising order. */
using Ends = std::pair<std::uint32_t, std::uint32_t>;

/** Borders as often as triangles have them: once where the surface is open. */
std::vector<Ends> bordersOf(const MeshView& mesh) {
  std::vector<Ends> borders;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    for (int e = 0; e < 3; ++e) {
      if (mesh.neighbours[t][e] == HD_NO_INDEX)
        borders.push_back(std::minmax({mesh.triangles[t][e], mesh.triangles[t][(e + 1) % 3]}));
    }
  }
  std::sort(borders.begin(), borders.end());
  return borders;
}

Error openMesh(const MeshView& mesh) {
  const std::vector<Ends> borders = bordersOf(mesh);
  std::size_t open = 0, others = 0;
  Ends first_open, first_other;
  for (std::size_t i = 0, end; i < borders.size(); i = end) {
    for (end = i + 1; end < borders.size() && borders[end] == borders[i];) ++end;
    if (end - i == 1 && open++ == 0) first_open = borders[i];
    if (end - i > 1 && others++ == 0) first_other = borders[i];
  }
  const auto where = [&](const Ends& ends) {
    const auto at = [&](std::uint32_t v) {
      return Vec3(mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]);
    };
    const Vec3 x = (at(ends.first) + at(ends.second)) / 2;
    return fmt::format("edge at {:.6g} {:.6g} {:.6g} m", x.x(), x.y(), x.z());
  };
  if (open > 0) {
    return {ErrorCode::kBadMesh, where(first_open),
            fmt::format("the surface is open there; it has {} such edges", open),
            "close the holes, have them filled (--fill-holes), or weld with a larger distance"};
  }
  return {
      ErrorCode::kBadMesh, where(first_other),
      fmt::format("more than two triangles meet there, or the surface has one side only; it has {} such edges", others),
      "keep solids apart that touch there, or have the inside told by winding numbers (--fill-holes)"};
}

/** About the mesh; kInvalidArgument if building would take too much memory. */
Result<VolumeLattice> latticeOf(const MeshView& mesh, double voxel_m, const VolumeOptions& options,
                                BuildMonitor& monitor) {
  Vec3 lower = mesh.vertex(0, 0), upper = lower;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    for (int c = 0; c < 3; ++c) {
      lower = lower.cwiseMin(mesh.vertex(t, c));
      upper = upper.cwiseMax(mesh.vertex(t, c));
    }
  }
  VolumeLattice lattice = latticeAbout(lower, upper, voxel_m, options.margin_voxels);
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  const auto extent = extentOf(mesh, voxel_m, monitor);
  if (!extent) return extent.error();
  const double needed = bytesToBuild(lattice, *extent, options);
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

Result<VolumeImage> writeWith(const ClosedSurface& surface, const VolumeLattice& lattice, const VolumeOptions& options,
                              BuildMonitor& monitor) {
  MeshField field(surface, lattice);
  VolumeSource source;
  source.lattice = lattice;
  source.field = &field;
  source.vertices = verticesOf(*surface.mesh);
  source.triangles = trianglesOf(*surface.mesh);
  source.options = options;
  return writeVolume(source, monitor);
}

}  // namespace

Result<SurfaceExtent> extentOf(const MeshView& mesh, double voxel_m, BuildMonitor& monitor) {
  constexpr double kCounted = 1000;  // Up to so many samples are counted, more are estimated (at most 15 % high).
  constexpr double kUnasked = 100'000;
  const double step = voxel_m / kSamplesPerVoxel;
  SurfaceExtent out;
  double counted = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    const Vec3 a = mesh.vertex(t, 0), b = mesh.vertex(t, 1), c = mesh.vertex(t, 2);
    out.area += (b - a).cross(c - a).norm() / 2;
    double samples = mostSamples(a, b, c, step);
    if (samples < kCounted) {
      samples = 0;
      sampleSurface(verticesOf(mesh), trianglesOf(mesh).subspan(t, 1), step, [&](const SurfaceSample&) { ++samples; });
      counted += samples + 1;
    }
    if (counted >= kUnasked) {
      if (!monitor.progress(0, "measuring the surface")) return cancelled();
      counted = 0;
    }
    out.samples += samples;
  }
  return out;
}

double bytesToBuild(const VolumeLattice& lattice, const SurfaceExtent& surface, const VolumeOptions& options) {
  const double cells = static_cast<double>(lattice.cells[0]) * lattice.cells[1] * lattice.cells[2];
  const double in_voxels = surface.area / (lattice.voxel * lattice.voxel), edge = HD_BRICK_EDGE;
  // A surface crosses 1.5 cells for each cell's area on average; the band adds cells in proportion to its width.
  const double bricks = std::min(cells, in_voxels / (edge * edge) * (1.5 + 2 * (options.band_voxels + 1) / edge));
  const double spacing = options.point_spacing_m > 0 ? options.point_spacing_m / lattice.voxel : 1;
  // Samples of needles, more than their area suggests, may each become a point.
  const double needles = std::max(0.0, surface.samples - 2 * 9 * in_voxels);
  // Every point is one of the samples, however small a spacing is asked for.
  const double points = std::min(surface.samples, 1.5 * in_voxels / (spacing * spacing) + needles);
  // 56 bytes a sample, and 32 while they are sorted.
  return cells * 10 + bricks * 2 * 2 * HD_BRICK_STRIDE + points * (2 * 56 + 2 * 18) + surface.samples * (56 + 32);
}

Result<VolumeImage> volumeOfMesh(const MeshView& mesh, double voxel_m, const VolumeOptions& options,
                                 BuildMonitor& monitor) {
  const bool closed = (mesh.flags & HD_MESH_CLOSED) != 0;
  if (!closed && !options.fill_holes) return openMesh(mesh);
  const auto lattice = latticeOf(mesh, voxel_m, options, monitor);
  if (!lattice) return lattice.error();
  const auto surface = closeSurface(mesh, *lattice, monitor);
  if (!surface) return surface.error();
  return writeWith(**surface, *lattice, options, monitor);
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
