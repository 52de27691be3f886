/** @file
 * The stroke on which haptic-bench cost times ticks and queries.
 */
#pragma once

#include <cstddef>
#include <vector>

#include "rt/scene/mesh_view.h"

namespace haptic_bench {

constexpr double kStrokeDt = 1e-3;     // [s]
constexpr double kStrokeAbove = 1e-5;  // Where it begins [m].
constexpr double kStrokeDepth = 1e-3;  // [m]

/**
 * The hand's way round a bumpy sphere, always over new ground, over the mesh itself: a coarse one lies below the sphere
 * by more than a millimetre.
 */
class MeshStroke {
 public:
  /** `speed` in m/s. Throws Failure where the mesh is not found. */
  MeshStroke(const hapticd::MeshView& mesh, double seconds, double speed);
  [[nodiscard]] std::size_t ticks() const { return along_.size() - 1; }
  /** At tick i, 0 to ticks(), `height` above the mesh. */
  [[nodiscard]] hapticd::Vec3 at(std::size_t i, double height) const { return (radius_[i] + height) * along_[i]; }

 private:
  std::vector<hapticd::Vec3> along_;
  std::vector<double> radius_;
};

}  // namespace haptic_bench
