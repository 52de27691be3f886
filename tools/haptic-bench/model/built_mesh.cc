#include "tools/haptic-bench/model/built_mesh.h"

#include "daemon/builder/build.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

hapticd::SnapshotMemory buildMesh(const Model& model) {
  hapticd::BuildMonitor monitor;
  const hapticd::BuiltSnapshot built = orFail(hapticd::buildSnapshot(upload(model), monitor));
  return orFail(hapticd::openSnapshot(orFail(built.memfd.share()), false));
}

}  // namespace haptic_bench
