/** @file
 * What the load benchmarks touch: a closed bumpy surface about the origin, and a stroke over it.
 */
#pragma once

#include <cstdint>
#include <vector>

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** r(u) = radius (1 + bumps * waves(u)) over directions u, |waves| <= 1: a sphere, or a smooth statue of one. */
struct BumpySphere {
  double radius = 0.05;  ///< [m]
  double bumps = 0;      ///< Height of the bumps, of the radius.

  [[nodiscard]] Vec3 point(const Vec3& direction) const;
  [[nodiscard]] Vec3 normal(const Vec3& direction) const;
};

/** S stacks by 2 S slices, S the least whose 4 S (S - 1) triangles are at least `triangles`. */
[[nodiscard]] Model tessellate(const BumpySphere& shape, std::uint32_t triangles);

/** How a hand strokes a surface. */
struct Stroke {
  double speed = 0.1;       ///< Along the surface [m/s].
  double force = 1;         ///< [N]
  double stiffness = 1000;  ///< Of the surface: it is pressed in by force / stiffness [N/m].
  double tilt = 0.5;        ///< Of the way about the origin, against the rows of triangles [rad].
};

/** Places of the hand, one a tick, and what the smooth surface would make it feel there. */
struct Stroked {
  std::vector<Vec3> hips;
  std::vector<Vec3> forces;
};

inline constexpr double kTick_s = 1e-3;        ///< Period of the servo.
inline constexpr std::size_t kApproach = 200;  ///< Ticks in which the hand comes down from outside.
inline constexpr std::size_t kSettled = 500;   ///< From here on a slow client too knows of the stroke.

/** In-trajectory of equation 4.2 of the thesis, p_out - n F / k, of kApproach ticks and `seconds`. */
[[nodiscard]] Stroked strokeOver(const BumpySphere& shape, const Stroke& stroke, double seconds);

}  // namespace haptic_bench
