#include "rt/render/model_solid.h"

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

Vec3 wayOut(const float (*halfspace)[4], std::uint32_t count, const Vec3& x) HD_RT {
  count = std::min(count, HD_HALFSPACES);
  std::array<Vec3, HD_HALFSPACES> n;
  std::array<double, HD_HALFSPACES> depth;
  for (std::uint32_t i = 0; i < count; ++i) {
    n[i] = Vec3(halfspace[i][0], halfspace[i][1], halfspace[i][2]);
    depth[i] = halfspace[i][3] - n[i].dot(x);
  }
  // Twice the cost at e, times kCornerSoftness.
  const auto cost = [&](const Vec3& e) {
    double sum = kCornerSoftness * e.squaredNorm();
    for (std::uint32_t i = 0; i < count; ++i) {
      const double left = std::max(0.0, depth[i] - n[i].dot(e));
      sum += left * left;
    }
    return sum;
  };
  Vec3 e = Vec3::Zero();
  double present = cost(e);
  for (int step = 0; step < kCornerSteps; ++step) {
    Mat3 hessian = kCornerSoftness * Mat3::Identity();
    Vec3 downhill = -kCornerSoftness * e;
    bool any = false;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double left = depth[i] - n[i].dot(e);
      if (left <= 0) continue;
      any = true;
      hessian += n[i] * n[i].transpose();
      downhill += left * n[i];
    }
    if (!any && e.isZero(0)) return e;
    const Vec3 move = hessian.llt().solve(downhill);
    // A full step is exact while the same planes hold; else it is halved until it is downhill enough.
    double length = 1;
    double next = cost(e + move);
    const double slope = downhill.dot(move);
    for (int halved = 0; halved < 10 && next > present - 0.5 * length * slope; ++halved) {
      length *= 0.5;
      next = cost(e + length * move);
    }
    if (!(next < present)) break;
    e += length * move;
    present = next;
  }
  return (1 + kCornerSoftness) * e;
}

}  // namespace hapticd
