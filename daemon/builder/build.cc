#include "daemon/builder/build.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <time.h>

#include <cstring>
#include <new>
#include <utility>

#include "daemon/builder/mesh/snapshot_writer.h"
#include "daemon/builder/volume/mesh_volume.h"
#include "daemon/builder/volume/thin_walls.h"

namespace hapticd {
namespace {

std::int64_t now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/** The volume of the mesh in a snapshot, in sealed memory. */
Result<Memfd> buildVolume(std::span<const std::byte> snapshot, const MeshSource& source, BuildMonitor& monitor) {
  const auto mesh = validateSnapshot(snapshot);
  if (!mesh) return mesh.error();
  VolumeOptions options;
  options.point_spacing_m = double{source.request.point_spacing_m};
  options.sensation = true;
  options.fill_holes = source.fill_holes;
  const auto image = volumeOfMesh(*mesh, double{source.request.voxel_m}, options, monitor);
  if (!image) return image.error();
  const auto bytes = bytesOf(*image);
  auto memfd = Memfd::create("hapticd-volume", bytes.size());
  if (!memfd) return memfd;
  {
    auto mapping = memfd->map(Memfd::Access::kWrite);
    if (!mapping) return mapping.error();
    std::memcpy(mapping->data(), bytes.data(), bytes.size());
  }
  if (const auto sealed = memfd->seal(Seals::kFrozen); !sealed) return sealed.error();
  hd_volume_header h;
  std::memcpy(&h, bytes.data(), sizeof h);
  monitor.notes.push_back(fmt::format(
      "volume: voxels of {:.4g} mm, {} surface points, {} bricks, {:.4g} cm3, {:.1f} MB", double{h.voxel} * 1e3,
      h.point_count, h.brick_count, h.mass.volume * 1e6, static_cast<double>(h.total_bytes) * 1e-6));
  const auto view = validateVolume(bytes);
  if (!view) return view.error();
  if (std::string thin = noteOfThinWalls(*view); !thin.empty()) monitor.notes.push_back("volume: " + std::move(thin));
  return memfd;
}

Result<BuiltSnapshot> build(std::span<const std::byte> upload, BuildMonitor& whole) {
  const std::int64_t begin = now();
  auto source = readUpload(upload);
  if (!source) return source.error();
  const float mesh_part = source->as_volume ? 0.1f : 1;  // A volume takes by far the most of the time.
  BuildMonitor monitor;
  monitor.progress = [&](float x, const char* stage) { return whole.progress(x * mesh_part, stage); };
  // Fractions are shares of the time that a million triangles take.
  if (!monitor.progress(0.0f, "checking")) return cancelled();
  if (const auto checked = checkNumbers(*source); !checked) return checked.error();
  if (!monitor.progress(0.03f, "welding vertices")) return cancelled();
  Mesh mesh = weld(*source, monitor);
  if (mesh.triangles.empty())
    return Error{ErrorCode::kBadMesh, "mesh", "no triangle has an area", "check the scale and the export"};
  if (!monitor.progress(0.15f, "connecting triangles")) return cancelled();
  dropDuplicates(mesh, monitor);
  connect(mesh, monitor);
  stitch(mesh, double{source->weld_m}, monitor);
  if (mesh.triangles.empty()) {
    return Error{ErrorCode::kBadMesh, "mesh", "all its triangles are too small to be told apart so far from the origin",
                 "check the scale and the export, or move it nearer to the origin"};
  }
  if (!monitor.progress(0.35f, "orienting the surface")) return cancelled();
  orient(mesh, monitor);
  noteHoles(mesh, monitor);
  const auto treeProgress = [&](float x) { return monitor.progress(0.45f + 0.45f * x, "building the tree"); };
  if (!treeProgress(0)) return cancelled();
  const Bvh bvh = buildBvh(mesh, treeProgress);
  if (bvh.nodes.empty() || !monitor.progress(0.9f, "writing")) return cancelled();
  auto memfd = writeSnapshot(mesh, bvh, monitor);
  if (!memfd) return memfd.error();

  BuiltSnapshot built;
  built.memfd = std::move(*memfd);
  auto mapping = built.memfd.map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  if (source->as_volume) {
    BuildMonitor rest;
    rest.progress = [&](float x, const char* stage) { return whole.progress(mesh_part + (1 - mesh_part) * x, stage); };
    auto volume = buildVolume(mapping->bytes(), *source, rest);
    if (!volume) return volume.error();
    built.volume = std::move(*volume);
    monitor.notes.insert(monitor.notes.end(), rest.notes.begin(), rest.notes.end());
  }
  whole.notes = std::move(monitor.notes);
  const auto& header = *mapping->as<hd_snapshot_header>();
  built.stats.vertices = header.vertex_count;
  built.stats.triangles = header.triangle_count;
  built.stats.nodes = header.node_count;
  built.stats.depth = header.depth;
  built.stats.flags = header.flags;
  built.stats.bytes = header.total_bytes;
  std::memcpy(built.stats.lower, header.lower, sizeof header.lower);
  std::memcpy(built.stats.upper, header.upper, sizeof header.upper);
  built.stats.build_ns = now() - begin;
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  built.stats.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  return built;
}

}  // namespace

Result<BuiltSnapshot> buildSnapshot(std::span<const std::byte> upload, BuildMonitor& monitor) {
  try {
    return build(upload, monitor);
  } catch (const std::bad_alloc&) {
    rlimit limit{};
    ::getrlimit(RLIMIT_AS, &limit);
    const std::string most =
        limit.rlim_cur == RLIM_INFINITY ? "of this machine" : "of " + std::to_string(limit.rlim_cur) + " bytes";
    return Error{ErrorCode::kBuilderFailed, "build", "the mesh needs more memory than the limit " + most,
                 "raise builder.memory_mb, or simplify the mesh"};
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, "build", error.what(), {}};
  }
}

}  // namespace hapticd
