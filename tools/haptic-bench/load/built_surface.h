/** @file
 * A surface as the servo reads it and as a client keeps it.
 */
#pragma once

#include <hapticclient/surface.hpp>

#include "daemon/ipc/snapshot_memory.h"
#include "rt/scene/scene.h"
#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** Both sides of one mesh. Throws Failure when the builder refuses it. */
class BuiltSurface {
 public:
  explicit BuiltSurface(const Model& model);
  BuiltSurface(const BuiltSurface&) = delete;
  BuiltSurface& operator=(const BuiltSurface&) = delete;

  /** In entry 0. */
  [[nodiscard]] const hapticd::MeshTable& meshes() const { return meshes_; }
  [[nodiscard]] const haptic::SurfaceMesh& client() const { return client_; }

 private:
  hapticd::SnapshotMemory snapshot_;
  hapticd::MeshTable meshes_;
  haptic::SurfaceMesh client_;
};

/** The mesh for a client alone. */
[[nodiscard]] haptic::SurfaceMesh clientMesh(const Model& model);

}  // namespace haptic_bench
