/** @file
 * The distance field of a volume, one point at a time: the reference for vectorised detectors. Servo-safe.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/volume/volume_view.h"

namespace hapticd {

/** The distance to the surface, negative inside, as interpolated. */
struct DistanceSample {
  double value = 0;  ///< [m]
  Vec3 gradient =
      Vec3::Zero();   ///< Of the interpolation, in O; about unit. May be zero. Beyond the lattice: away from it.
  double error = 0;   ///< The true distance differs by no more than this [m].
  bool fine = false;  ///< From a brick.
};

/**
 * At any finite point: trilinear in the brick; where there is none, between the corners of the brick cell, deep inside
 * too; outside the lattice a lower bound, from the nearest point on its box. A trilinear value of a function that
 * grows no faster than 1 is off by sqrt(3)/2 of the cell's side at most (in the cell's middle; much less where the
 * surface is smooth), and by half a step of its 16 bits. Two coarse samples on both sides of a brick's border differ by
 * as much.
 */
[[nodiscard]] DistanceSample distanceAt(const VolumeView& volume, const Vec3& x_O) HD_RT;

}  // namespace hapticd
