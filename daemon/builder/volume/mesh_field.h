/** @file
 * The exact signed distance to a closed mesh: nearest point by the tree, side by the pseudo-normal.
 */
#pragma once

#include "daemon/builder/volume/volume_source.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** For meshes whose tree is built; some 2 us a value. The mesh must outlive it. */
class MeshField : public DistanceField {
 public:
  MeshField(const MeshView& mesh, const VolumeLattice& lattice) : mesh_(mesh), lattice_(lattice) {}
  [[nodiscard]] float at(const Lattice3& point) override { return within(point, kAnywhere); }
  void fill(const Lattice3& first, std::span<float, HD_BRICK_VALUES> out) override;

 private:
  [[nodiscard]] float within(const Lattice3& point, double reach) const;

  const MeshView& mesh_;
  VolumeLattice lattice_;
  static constexpr double kAnywhere = 1e9;  ///< Farther than any coordinate [m].
};

}  // namespace hapticd
