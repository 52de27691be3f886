/** @file
 * The three pairs that haptic-bench collide measures: models and motions by formula, so that anyone can make the same.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** A tool moved against a base. Lengths of the formulas are in mm; models and poses here in m. */
struct CollidePair {
  std::string name;  ///< bumpy, peg or frac.
  Model base;
  Model tool;
  double voxel = 0;                           ///< Edge of the base's field that the figures are given for [m].
  double contact_from = 0;                    ///< From here on the two touch, nearly always [s].
  double duration = 0;                        ///< Of the motion [s].
  hapticd::Pose (*pose)(double t) = nullptr;  ///< Of the tool in the base's frame.

  [[nodiscard]] std::vector<hapticd::Pose> poses(double rate_hz) const;
};

/** All closed, 2-manifold, outward. Throws Failure for a name that is none of the three. */
[[nodiscard]] CollidePair makePair(const std::string& name);

/** Height of the fracture surface over 60 x 60 mm, all in mm. */
[[nodiscard]] double fractureHeight(double x, double y);

}  // namespace haptic_bench
