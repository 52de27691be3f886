#include "daemon/builder/build.h"

#include <sys/resource.h>
#include <time.h>

#include <cstring>
#include <new>

#include "daemon/builder/snapshot_writer.h"

namespace hapticd {
namespace {

std::int64_t now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

Error cancelled() { return {ErrorCode::kCancelled, "build", {}, {}}; }

Result<BuiltSnapshot> build(std::span<const std::byte> upload, BuildMonitor& monitor) {
  const std::int64_t begin = now();
  auto source = readUpload(upload);
  if (!source) return source.error();
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
  if (!monitor.progress(0.35f, "orienting the surface")) return cancelled();
  orient(mesh, monitor);
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
