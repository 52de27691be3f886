/** @file
 * A built mesh as a sealed snapshot (proto/snapshot.h).
 */
#pragma once

#include "daemon/builder/mesh/bvh.h"
#include "daemon/ipc/memfd.h"

namespace hapticd {

/** Triangles in leaf order, vertices in the order of their first use, unused ones gone; sealed Seals::kFrozen. */
[[nodiscard]] Result<Memfd> writeSnapshot(const Mesh& mesh, const Bvh& bvh, BuildMonitor& monitor);

}  // namespace hapticd
