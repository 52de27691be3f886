/** @file
 * Builds a test mesh and opens the result as the daemon does.
 */
#pragma once

#include <gtest/gtest.h>

#include "daemon/ipc/snapshot_memory.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {

struct Built {
  SnapshotMemory memory;
  BuildStats stats;
  std::vector<std::string> notes;
};

inline Built build(const UploadMesh& mesh, std::uint32_t flags = 0, float weld_m = 0) {
  BuildMonitor monitor;
  Built out;
  auto snapshot = buildSnapshot(upload(mesh, flags, weld_m), monitor);
  EXPECT_TRUE(snapshot.ok()) << toString(snapshot.error());
  if (!snapshot) return out;
  out.stats = snapshot->stats;
  out.notes = monitor.notes;
  auto opened = openSnapshot(std::move(*snapshot->memfd.share()), false);
  EXPECT_TRUE(opened.ok()) << toString(opened.error());
  if (opened) out.memory = std::move(*opened);
  return out;
}

inline Error refusal(const UploadMesh& mesh, std::uint32_t flags = 0) {
  BuildMonitor monitor;
  auto snapshot = buildSnapshot(upload(mesh, flags), monitor);
  EXPECT_FALSE(snapshot.ok());
  return snapshot.ok() ? Error{} : snapshot.error();
}

inline double signedVolume(const MeshView& mesh) {
  double volume = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t)
    volume += mesh.vertex(t, 0).dot(mesh.vertex(t, 1).cross(mesh.vertex(t, 2))) / 6;
  return volume;
}

}  // namespace hapticd::test
