#include "daemon/builder/vdb/cached_vdb.h"

#include <fmt/core.h>

#include <cstring>
#include <sstream>

#include "daemon/builder/vdb/band.h"
#include "daemon/builder/vdb/write_vdb.h"
#include "daemon/builder/volume/mesh_field.h"
#include "daemon/builder/volume/volume_writer.h"
#include "daemon/ipc/cached_build.h"
#include "rt/scene/snapshot_checksum.h"

namespace hapticd {
namespace {

/** Aligned as the checks want it. */
VolumeImage copyOf(std::span<const std::byte> bytes) {
  VolumeImage copy((bytes.size() + sizeof(VolumeBlock) - 1) / sizeof(VolumeBlock));
  std::memcpy(copy.data(), bytes.data(), bytes.size());
  return copy;
}

Result<std::string> make(std::span<const std::byte> cached) {
  CachedBuildHead head;
  if (cached.size() < sizeof head) return Error{ErrorCode::kBadSnapshot, "cached volume", "is cut short", {}};
  std::memcpy(&head, cached.data(), sizeof head);
  const std::size_t volume_at = sizeof head + head.snapshot_bytes;
  if (!head.fits(cached.size()) || head.volume_bytes < sizeof(hd_volume_header) ||
      snapshotChecksum(cached.subspan(volume_at, sizeof(hd_volume_header))) != head.volume_header)
    return Error{ErrorCode::kBadSnapshot, "cached volume", "is damaged or of another version", {}};
  const VolumeImage snapshot = copyOf(cached.subspan(sizeof head, head.snapshot_bytes));
  const VolumeImage image = copyOf(cached.subspan(volume_at, head.volume_bytes));
  const auto mesh = validateSnapshot(bytesOf(snapshot).first(head.snapshot_bytes));
  if (!mesh) return mesh.error();
  const auto volume = validateVolume(bytesOf(image).first(head.volume_bytes));
  if (!volume) return volume.error();

  hd_snapshot_header of_mesh;
  std::memcpy(&of_mesh, snapshot.data(), sizeof of_mesh);
  const VolumeLattice lattice = latticeOf(*volume);
  BuildMonitor monitor;
  const auto surface = closeSurface(*mesh, lattice, monitor);
  if (!surface) return surface.error();
  MeshField field(**surface, lattice);
  std::ostringstream out;
  const auto written = writeVdb(out, *volume, &field,
                                fmt::format("mesh {:016x} volume {:016x}", of_mesh.checksum, volume->header->checksum));
  if (!written) return written.error();
  return std::move(out).str();
}

}  // namespace

Result<std::string> vdbOfCached(std::span<const std::byte> cached) {
  try {
    return make(cached);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kSystem, "vdb", "does not fit into the memory allowed", "raise builder.memory_mb"};
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, "vdb", error.what(), {}};
  }
}

}  // namespace hapticd
