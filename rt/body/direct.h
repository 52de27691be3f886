/** @file
 * Direct rendering (thesis section 1.2.3): the tool is where the device is, and overlap pushes back. Nothing lags
 * behind the hand and nothing is damped on the way; in return the overlap is real, and a late detector is felt as a
 * late wall.
 */
#pragma once

#include <algorithm>
#include <span>

#include "rt/body/response.h"

namespace hapticd {

struct DirectGains {
  double stiffness = 500;  ///< Of all touches together [N/m].
  double damping = 0;      ///< Of all touches together [N s/m].
};

/**
 * What the device is to feel, about the point from which r_a counts [N, N m]. The stiffness is shared by the touches
 * that overlap, so that a face is no stiffer than a corner. Damping only adds to a push and takes from it: no touch
 * pulls.
 */
[[nodiscard]] inline Wrench directWrench(std::span<const Touch> touches, const Twist& a, const Twist& b,
                                         const DirectGains& gains) HD_RT {
  double pushing = 0;
  for (const Touch& touch : touches) pushing += touch.gap < 0 ? 1 : 0;
  Wrench out;
  for (const Touch& touch : touches) {
    if (!(touch.gap < 0)) continue;
    const double u = relativeVelocity(a, b, touch).dot(touch.n);
    const double force = std::max(0.0, (-gains.stiffness * touch.gap - gains.damping * u) / pushing);
    out.force += force * touch.n;
    out.torque += touch.r_a.cross(force * touch.n);
  }
  return out;
}

}  // namespace hapticd
