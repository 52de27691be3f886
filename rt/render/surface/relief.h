/** @file
 * Height above a surface from a grey picture, at any point of any shape: the picture is laid on from the three axes of
 * the object and blended by the surface's normal, so that no mesh needs texture coordinates.
 */
#pragma once

#include "rt/base/math.h"
#include "rt/scene/texture.h"

namespace hapticd {

/** Height [m], at most 0, and its gradient (no unit). */
struct ReliefPoint {
  double height = 0;
  Vec3 gradient = Vec3::Zero();
};

/**
 * The relief at a surface point x with unit normal n, both in the object's frame. Seen along the axes x, y, z the
 * picture's width and height lie along (y, z), (x, z) and (x, y); its middle is at the object's origin, and it goes on
 * mirrored at its edges. Between pixels a biquadratic B-spline: height and gradient are continuous, and along a side of
 * the picture no slope is steeper than the steepest step between two neighbours there. Servo-safe: 27 pixels are read.
 */
[[nodiscard]] ReliefPoint reliefAt(const ReliefView& relief, const SurfaceParameters& surface, const Vec3& x,
                                   const Vec3& n) HD_RT;

}  // namespace hapticd
