/** @file
 * A model as the daemon's builder makes it and its servo reads it.
 */
#pragma once

#include "daemon/ipc/snapshot_memory.h"
#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** Throws Failure when the builder refuses the mesh. */
[[nodiscard]] hapticd::SnapshotMemory buildMesh(const Model& model);

}  // namespace haptic_bench
