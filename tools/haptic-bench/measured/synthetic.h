/** @file
 * A recording with known truth: what the apparatus of the thesis would have measured along an out-trajectory.
 */
#pragma once

#include "tools/haptic-bench/measured/recording.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

struct Apparatus {
  double force_hz = 5000;
  double pose_hz = 60;
  double tip_radius = 0.0015;    ///< [m]
  Vec3 tip_S = Vec3(0, 0, 0.1);  ///< Centre of its ball [m].
  ProbeLoad load;                ///< Bias and weight that the sensor feels.
  double free_s = 1;             ///< It begins this long in the air, turning.
  Pose X_OM;                     ///< Where the mesh lies in the object's frame.
  double force_noise = 0;        ///< Standard deviation on each axis [N].
  double pose_noise = 0;         ///< The same [m].
  std::uint32_t seed = 1;
};

/** The out-trajectory is in the mesh's frame, at whatever rate; the object stands still. */
[[nodiscard]] Recording record(const std::vector<SurfaceSample>& out, const Apparatus& apparatus);

}  // namespace haptic_bench
