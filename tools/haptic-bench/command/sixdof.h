/** @file
 * How far a felt force or torque is from the truth along a trajectory, and whether that is good.
 */
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/base/math.h"

namespace haptic_bench {

/** Errors of one vector over a trajectory. */
struct Judged {
  static constexpr double kFelt = 0.05;  ///< Truth below this share of its greatest has no direction to speak of.
  static constexpr double kPart = 0.05, kDegrees = 3;  ///< Good is less.

  double square = 0, size = 0, worst = 0, angle = 0, worst_angle = 0, greatest = 0;
  int samples = 0, directed = 0;

  void add(const hapticd::Vec3& felt, const hapticd::Vec3& truth) {
    greatest = std::max(greatest, truth.norm());
    const double error = (felt - truth).norm();
    square += error * error;
    size += truth.squaredNorm();
    worst = std::max(worst, error);
    ++samples;
    if (truth.norm() < kFelt * greatest || truth.isZero(0) || felt.isZero(0)) return;
    const double turn = std::acos(std::clamp(felt.normalized().dot(truth.normalized()), -1.0, 1.0));
    angle += turn * turn;
    worst_angle = std::max(worst_angle, turn);
    ++directed;
  }
  [[nodiscard]] double rms() const { return std::sqrt(square / samples); }
  [[nodiscard]] double relative() const { return size > 0 ? std::sqrt(square / size) : NAN; }
  [[nodiscard]] double degrees() const { return directed > 0 ? std::sqrt(angle / directed) * 180 / EIGEN_PI : NAN; }
  /** Root mean square of the truth. */
  [[nodiscard]] double truth() const { return std::sqrt(size / samples); }
  /** Within 5 % and 3 degrees; where nothing is to be felt, within 5 % of `scale`. */
  [[nodiscard]] bool isGood(double scale) const {
    return size == 0 ? rms() <= kPart * scale : relative() < kPart && degrees() < kDegrees;
  }
};

}  // namespace haptic_bench
