/** @file
 * The exact signed distance to a mesh: nearest point by the tree, side by the pseudo-normal or the winding number.
 */
#pragma once

#include "daemon/builder/volume/closed_surface.h"
#include "daemon/builder/volume/volume_source.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/**
 * For meshes whose tree is built; some 2 us a value. The mesh must outlive it. Without `winding` it must be closed;
 * with it the side is where more than half of it winds about the point.
 */
class MeshField : public DistanceField {
 public:
  MeshField(const MeshView& mesh, const VolumeLattice& lattice, const WindingTree* winding = nullptr)
      : mesh_(mesh), lattice_(lattice), winding_(winding) {}
  MeshField(const ClosedSurface& surface, const VolumeLattice& lattice)
      : MeshField(*surface.mesh, lattice, surface.winding ? &*surface.winding : nullptr) {}
  [[nodiscard]] float at(const Lattice3& point) override { return within(point, kAnywhere, 0); }
  void fill(const Lattice3& first, std::span<float, HD_BRICK_VALUES> out) override;

 private:
  /** `neighbour`: the value a voxel away, or 0: none is known. */
  [[nodiscard]] float within(const Lattice3& point, double reach, double neighbour) const;

  const MeshView& mesh_;
  VolumeLattice lattice_;
  const WindingTree* winding_;
  static constexpr double kAnywhere = 1e9;  ///< Farther than any coordinate [m].
};

}  // namespace hapticd
