/** @file
 * What a hand-held probe measures: a fast stream of forces and a slow one of poses, of the thesis's apparatus (section
 * 4.2.1: force at 5 kHz, pose at 60 Hz), merged and freed of the probe's own weight.
 */
#pragma once

#include <string>
#include <vector>

#include "rt/base/math.h"
#include "tools/haptic-bench/trajectory/table.h"

namespace haptic_bench {

using hapticd::Pose;
using hapticd::Vec3;

/** Force on the sensor, in its own frame S. */
struct ForceSample {
  double t_s = 0;
  Vec3 f_S = Vec3::Zero();  ///< [N]
};

/** The probe's pose in the object's frame O (that of its markers), or the tracker's where the object stands still. */
struct PoseSample {
  double t_s = 0;
  Pose X_OS;
  Eigen::Quaterniond q_WO = Eigen::Quaterniond::Identity();  ///< Rotation of the object: where down is.
};

/** The two streams on one clock. */
struct Recording {
  std::vector<ForceSample> forces;
  std::vector<PoseSample> poses;
};

/**
 * Forces: columns t, fx, fy, fz. Poses: t, x, y, z, qw, qx, qy, qz of the probe and, where the object moves too,
 * object_x ..., object_qw ... (all seven or none), all in the tracker's frame W, z up. Both keep their times;
 * `max_gap_s` as for readTimes(). Throws Failure with file and line.
 */
[[nodiscard]] Recording readRecording(const std::string& forces_path, const std::string& poses_path,
                                      double max_gap_s = 0);

/** What the sensor feels without contact: constant bias and the weight of what hangs on it. */
struct ProbeLoad {
  Vec3 bias_S = Vec3::Zero();  ///< [N]
  double weight = 0;           ///< [N], pulling down in W.
};

/** By how much the poses' times are late against the forces'. */
struct ClockLag {
  double lag_s = 0;
  double deviation_s = 0;  ///< Standard deviation of the above; 0: it cannot be told.
};

/** One instant of both streams. */
struct ProbeSample {
  double t_s = 0;
  Vec3 tip_O = Vec3::Zero();    ///< Centre of the ball at the tip [m].
  Vec3 force_O = Vec3::Zero();  ///< Of the contact on the probe [N].
};

/** How to merge. */
struct MergeOptions {
  double rate_hz = 1000;      ///< Of the result; each is the mean of the forces that are nearest to it.
  Vec3 tip_S = Vec3::Zero();  ///< Centre of the tip's ball in the sensor's frame [m].
  double free_s = 0;          ///< So long from the first force on nothing is touched: the load is found there.
  ProbeLoad load;             ///< Used where free_s is 0.
};

/**
 * The end of the free time [s]. Counted from the forces, which tell what touches: poses that come late, or are put on
 * another clock, must not shift it into the contact.
 */
[[nodiscard]] double freeUntil(const Recording& recording, double free_s);

/**
 * The load by least squares over a stretch without contact. Where the probe does not turn there, bias and weight cannot
 * be told apart: the smallest pair that explains the forces is taken, good for that orientation alone. Throws Failure
 * where what hangs on the sensor would be pulled upwards.
 */
[[nodiscard]] ProbeLoad estimateLoad(const Recording& recording, double until_s);

/**
 * How late the poses are, from the weight that turns over a stretch without contact: five unknowns by Gauss and
 * Newton's steps. Nothing where the probe does not turn or weighs nothing.
 */
[[nodiscard]] ClockLag estimateLag(const Recording& recording, double until_s);

/**
 * Both streams at rate_hz over the time they share, from free_s on. Poses between two of the slow stream lie on the
 * cubic through four (position) and the great arc (rotation). `load`: what was taken off. Throws Failure where they
 * share no time, or so much that there would be more than kMaxSamples.
 */
[[nodiscard]] std::vector<ProbeSample> merge(const Recording& recording, const MergeOptions& options,
                                             ProbeLoad* load = nullptr);

}  // namespace haptic_bench
