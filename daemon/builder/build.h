/** @file
 * From an upload to a snapshot: checks, repairs, tree, writing. No process or socket here.
 */
#pragma once

#include "daemon/builder/mesh/mesh.h"
#include "daemon/ipc/build_stats.h"
#include "daemon/ipc/memfd.h"

namespace hapticd {

struct BuiltSnapshot {
  Memfd memfd;
  Memfd volume;  ///< proto/volume.h, if the upload asks for it; sealed Seals::kFrozen. Else not valid.
  BuildStats stats;
};

/**
 * kBadMesh with the triangle or vertex at fault, kCancelled when the monitor says so, kBuilderFailed when memory is
 * short. About 0.5 s for a million triangles. Never throws.
 */
[[nodiscard]] Result<BuiltSnapshot> buildSnapshot(std::span<const std::byte> upload, BuildMonitor& monitor);

}  // namespace hapticd
