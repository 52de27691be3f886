#include "rt/render/halfspaces.h"

#include <algorithm>
#include <array>

namespace hapticd {

SolidDepth solidDepth(const float (*halfspace)[4], std::uint32_t count, double rounding, const Vec3& x) HD_RT {
  count = std::min(count, HD_HALFSPACES);
  struct Face {
    double slack;
    Vec3 n;
  };
  std::array<Face, HD_HALFSPACES> face;
  double least = 1e300;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 n(halfspace[i][0], halfspace[i][1], halfspace[i][2]);
    face[i] = {halfspace[i][3] - n.dot(x), n};
    least = std::min(least, face[i].slack);
  }
  // Only faces within `rounding` of the least can carry weight. Sorted by slack, the nearest first.
  std::array<Face, HD_HALFSPACES> near;
  std::uint32_t m = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (face[i].slack > least + rounding) continue;
    std::uint32_t at = m++;
    for (; at > 0 && near[at - 1].slack > face[i].slack; --at) near[at] = near[at - 1];
    near[at] = face[i];
  }
  if (m == 0) return {};
  // Projection of -slack / rounding on the simplex: l_i = max(0, (level - slack_i) / rounding), summing to one.
  double sum = 0;
  double level = 0;
  std::uint32_t used = 0;
  for (std::uint32_t i = 0; i < m; ++i) {
    const double candidate = (rounding + sum + near[i].slack) / (i + 1);
    if (i > 0 && near[i].slack >= candidate) break;
    sum += near[i].slack;
    level = candidate;
    used = i + 1;
  }
  SolidDepth out;
  double squares = 0;
  for (std::uint32_t i = 0; i < used; ++i) {
    const double weight = (level - near[i].slack) / rounding;
    out.depth += weight * near[i].slack;
    out.normal += weight * near[i].n;
    squares += weight * weight;
  }
  out.depth += 0.5 * rounding * (squares - 1);
  return out;
}

}  // namespace hapticd
