/** @file
 * What a hand does and what it should feel: the benchmark's input. Thesis section 4.2.2.
 */
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rt/base/math.h"
#include "tools/haptic-bench/trial/surface.h"

namespace haptic_bench {

using hapticd::Vec3;

inline constexpr double kMaxSamples = 1e7;  ///< Of a trajectory.

/** One instant of an in-trajectory. */
struct Sample {
  double t_s = 0;
  Vec3 hip = Vec3::Zero();    ///< Where the hand is, possibly inside the model [m].
  Vec3 proxy = Vec3::Zero();  ///< Where the contact should be [m]; with proxy_known.
  Vec3 force = Vec3::Zero();  ///< What the hand should feel [N]; with force_known.
  bool judged = true;         ///< Else nobody knows the truth here, and it is on the way only.
};

/** An in-trajectory: time rises from sample to sample. Never empty. */
struct Trajectory {
  std::string name;
  std::vector<Sample> samples;
  bool proxy_known = false;
  bool force_known = false;
  std::size_t unfit = 0;       ///< Samples that are not judged because a ball does not fit there.
  bool own_judgement = false;  ///< Which are judged its file says itself; else whether the device was armed.
  Vec3 start = Vec3::Zero();   ///< In free space, from where the hand comes to the first sample [m].

  [[nodiscard]] double duration_s() const { return samples.back().t_s - samples.front().t_s; }
  /** The middle one of the steps of time. */
  [[nodiscard]] double period_s() const;
};

/** Says on the standard error how many samples are judged, if not all are; where none is, no truth is known at all. */
void countJudged(Trajectory& trajectory);

/** One instant of an out-trajectory: on the surface, with the force that presses on it. */
struct SurfaceSample {
  double t_s = 0;
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< Outward, unit.
  double force = 0;            ///< Along the normal, on the hand [N].
};

/**
 * The in-trajectory that feels like an out-trajectory: p_in = p_out - f / k (thesis eq. 4.2, which prints |n| k: the
 * units need F / k), where f = F (n - mu t) and t is the direction in which the contact slides: without friction p_in =
 * p_out - n F / k. A ball's centre lies a radius outside of that. The hand comes from a point above the first one, F /
 * k off the surface.
 */
[[nodiscard]] Trajectory pressInto(const std::vector<SurfaceSample>& out, const Surface& surface);

/**
 * The same way at the same rate, at `factor` times the speed, above 0. What falls between two samples lies on the line
 * between them; where none does, as with whole factors and even steps, the samples are kept as they are.
 */
[[nodiscard]] Trajectory atSpeed(const Trajectory& trajectory, double factor);

}  // namespace haptic_bench
