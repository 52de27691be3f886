/** @file
 * The surface that a volume is made of: the mesh itself, or an open one with its holes closed.
 */
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "daemon/builder/build.h"
#include "daemon/builder/volume/volume_source.h"
#include "daemon/builder/volume/winding.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** A mesh with its tree, built here. */
struct BuiltMesh {
  BuiltSnapshot snapshot;
  Mapping mapping;
  MeshView view;
};

/** Welded, cleaned and turned outward; errors as buildSnapshot(). */
[[nodiscard]] Result<void> buildMesh(std::span<const std::byte> upload, BuildMonitor& monitor, BuiltMesh& out);

/** As a client uploads it. */
[[nodiscard]] std::vector<std::byte> uploadOf(std::span<const Float3> vertices, std::span<const Index3> triangles);

[[nodiscard]] std::span<const Float3> verticesOf(const MeshView& mesh);
[[nodiscard]] std::span<const Index3> trianglesOf(const MeshView& mesh);

/** What MeshField needs. Stays where it is made. */
struct ClosedSurface {
  const MeshView* mesh = nullptr;
  std::optional<WindingTree> winding;  ///< Where the pseudo-normals do not tell the side: a lid overlaps the rim.
  BuiltMesh own;                       ///< With the lid; empty for a mesh that is closed.
};

/**
 * Of a mesh that is closed: the mesh. Of an open one: with the lid of hole_fill.h over that lattice, the same every
 * time; turned about first if it looks inward as a whole. The mesh must outlive it. Errors of fillHoles() and
 * checkLattice().
 */
[[nodiscard]] Result<std::unique_ptr<ClosedSurface>> closeSurface(const MeshView& mesh, const VolumeLattice& lattice,
                                                                  BuildMonitor& monitor);

}  // namespace hapticd
