/** @file
 * Synthetic out-trajectories, and in-trajectories with a tremor, over the shapes of model/shapes.h. All are exact for
 * the smooth surface that the triangles stand for.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

/** Of every generator. */
struct Pace {
  double seconds = 10;
  double rate_hz = 1000;
  double force = 1;  ///< [N]
};

/** Samples in so many seconds, at least one. Throws Failure beyond kMaxSamples. */
[[nodiscard]] std::size_t samplesIn(double seconds, const Pace& pace);

/** From pole to pole of a sphere: polar angle and azimuth rise evenly. */
[[nodiscard]] std::vector<SurfaceSample> spiral(const Model& sphere, const Pace& pace, double turns);

/** Back and forth over a plane on a Lissajous figure of 3 : 2 that fills the middle half of it. */
[[nodiscard]] std::vector<SurfaceSample> lissajous(const Model& plane, const Pace& pace);

/**
 * Across a ridge from x = -length / 2 to length / 2 at y = `y`, by arc length at `speed` [m/s] (thesis figure 4.6). The
 * normal is that of the face: it jumps at foot and apex.
 */
[[nodiscard]] std::vector<SurfaceSample> profile(const Model& ridge, const Pace& pace, double length, double speed,
                                                 double y);

/** Through the bottom of a bowl to and fro along a tilted great circle, `speed` [m/s] there, at rest for the last
 * tenth. */
[[nodiscard]] std::vector<SurfaceSample> swing(const Model& bowl, const Pace& pace, double speed);

/** What a tremor does to a reach. */
struct Tremor {
  double amplitude = 0.0002;  ///< Root mean square, in each direction [m].
  std::uint32_t seed = 1;
};

/**
 * Over a plane, from one side of its middle half to the other and back by minimum jerk (Flash and Hogan 1985), two
 * seconds each way, with a tremor of 8 to 12 Hz: three sines with random phases in each direction. Along the normal the
 * tremor changes depth and force, and may lift the hand off; in the plane it changes the path.
 */
[[nodiscard]] std::vector<SurfaceSample> reach(const Model& plane, const Pace& pace, const Tremor& tremor,
                                               double stiffness);

}  // namespace haptic_bench
