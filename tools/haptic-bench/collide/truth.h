/** @file
 * What a contact is worth, by brute force: the integral of depth over the tool's surface inside the base, from samples
 * of the tool and the base's exact signed distance.
 */
#pragma once

#include <vector>

#include "daemon/ipc/snapshot_memory.h"
#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** Of one pose, in the base's frame. Torque about the tool's origin. */
struct Penalty {
  hapticd::Wrench integral;  ///< Force per stiffness and area: depth times outward normal, times area [m^3, m^4].
  double volume = 0;         ///< The integral of depth alone [m^3].
  double area = 0;           ///< [m^2]
  double deepest = 0;        ///< [m]
};

class Truth {
 public:
  /** Each triangle of the tool in `split`^2 equal parts, a sample in the middle of each. */
  Truth(const Model& base, const Model& tool, int split);

  /** Exact but for the sampling, for depths up to `reach` [m]; milliseconds to seconds. */
  [[nodiscard]] Penalty at(const hapticd::Pose& tool, double reach) const;

 private:
  struct Sample {
    Vec3 p;
    double area;
  };
  hapticd::SnapshotMemory base_;
  std::vector<Sample> samples_;
};

/** How far a wrench is from the truth. */
struct WrenchError {
  double force = 0;      ///< |F - F_true| / peak of |F_true|.
  double direction = 0;  ///< Between the forces [rad].
  double torque = 0;     ///< |T - T_true| / (peak of |F_true| times a lever).
};

/** `lever` in m; `peak` of the true force over the trajectory [m^3], not zero. */
[[nodiscard]] WrenchError compare(const hapticd::Wrench& wrench, const hapticd::Wrench& truth, double peak,
                                  double lever);

}  // namespace haptic_bench
