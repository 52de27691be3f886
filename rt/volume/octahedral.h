/** @file
 * Unit vectors in 32 bits: two coordinates of 16 bits on the unfolded octahedron (Cigolle et al., "A survey of
 * efficient representations for independent unit vectors", JCGT 3(2), 2014). Off by less than 0.004 degrees.
 * Servo-safe.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rt/base/math.h"

namespace hapticd {

/** Unit whatever the bits are. */
[[nodiscard]] inline Vec3 octahedralNormal(std::uint32_t bits) HD_RT {
  const double x = static_cast<std::int16_t>(bits & 0xffff) / 32767.0;
  const double y = static_cast<std::int16_t>(bits >> 16) / 32767.0;
  const double z = 1 - std::abs(x) - std::abs(y);
  const double fold = std::max(-z, 0.0);  // The lower half lies folded over the corners of the square.
  return Vec3(x - std::copysign(fold, x), y - std::copysign(fold, y), z).normalized();
}

/** Of a vector that is not zero. */
[[nodiscard]] inline std::uint32_t octahedralBits(const Vec3& n) HD_RT {
  const double sum = n.cwiseAbs().sum();
  double x = n.x() / sum, y = n.y() / sum;
  if (n.z() < 0) {
    const double u = (1 - std::abs(y)) * std::copysign(1.0, x), v = (1 - std::abs(x)) * std::copysign(1.0, y);
    x = u;
    y = v;
  }
  const auto part = [](double c) {
    return static_cast<std::uint32_t>(static_cast<std::uint16_t>(std::lround(std::clamp(c, -1.0, 1.0) * 32767)));
  };
  return part(x) | part(y) << 16;
}

}  // namespace hapticd
