/** @file
 * Forces that fit a device. Pure, real-time safe.
 */
#pragma once

#include "rt/base/math.h"

namespace hapticd {

/**
 * At most `limit` long in its direction, however large it is: then `cut` is set. Zero if it is not finite, or if
 * nothing is allowed.
 */
template <class Vector>
[[nodiscard]] Vector shortened(const Vector& v, double limit, bool& cut) HD_RT {
  const double most = v.cwiseAbs().maxCoeff();
  if (!v.allFinite() || !(most > 0) || !(limit > 0)) return Vector::Zero();
  const Vector scaled = v / most;
  const double length = scaled.norm();
  if (!(most > limit / length)) return v;
  cut = true;
  return scaled * (limit / length);
}

}  // namespace hapticd
