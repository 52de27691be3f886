#include "rt/render/model/model_solid.h"

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

namespace {

/** The planes at one place, and along a direction from it. */
struct Planes {
  std::uint32_t count;
  std::array<Vec3, HD_HALFSPACES> n;
  std::array<double, HD_HALFSPACES> left;   ///< d_i - n_i.(x + e); positive inside
  std::array<double, HD_HALFSPACES> climb;  ///< n_i.move, what a whole move takes off `left`
  std::array<double, HD_HALFSPACES> bend;   ///< where on the move `left` is zero; below zero: nowhere

  /**
   * How many moves lead to the least cost, whose slope along them is a rising broken line: `slope` at the start (below
   * zero), bending where a plane is left or met. `soft` is the part of its rise that no plane has. At most a bend each.
   */
  [[nodiscard]] double bestLength(double slope, double soft) HD_RT {
    for (std::uint32_t i = 0; i < count; ++i) bend[i] = climb[i] != 0 ? left[i] / climb[i] : -1;
    double at = 0;
    for (std::uint32_t bends = 0;; ++bends) {
      double rise = soft;
      double next = 1e300;
      for (std::uint32_t i = 0; i < count; ++i) {
        const bool ahead = bend[i] > at;
        if ((climb[i] > 0) == ahead) rise += climb[i] * climb[i];
        if (ahead) next = std::min(next, bend[i]);
      }
      const double least = at - slope / rise;
      if (least <= next || bends == count) return least;
      slope += rise * (next - at);
      at = next;
    }
  }
};

}  // namespace

Vec3 wayOut(const float (*halfspace)[4], std::uint32_t count, const Vec3& x) HD_RT {
  Planes planes;
  planes.count = std::min(count, HD_HALFSPACES);
  std::array<double, HD_HALFSPACES> depth;
  for (std::uint32_t i = 0; i < planes.count; ++i) {
    planes.n[i] = Vec3(halfspace[i][0], halfspace[i][1], halfspace[i][2]);
    depth[i] = halfspace[i][3] - planes.n[i].dot(x);
  }
  Vec3 e = Vec3::Zero();
  for (int step = 0; step < kCornerSteps; ++step) {
    Mat3 hessian = kCornerSoftness * Mat3::Identity();
    Vec3 downhill = -kCornerSoftness * e;
    bool any = false;
    for (std::uint32_t i = 0; i < planes.count; ++i) {
      planes.left[i] = depth[i] - planes.n[i].dot(e);
      if (planes.left[i] <= 0) continue;
      any = true;
      hessian += planes.n[i] * planes.n[i].transpose();
      downhill += planes.left[i] * planes.n[i];
    }
    if (!any && e.isZero(0)) return e;
    const Vec3 move = hessian.llt().solve(downhill);
    const double slope = -downhill.dot(move);
    if (!(slope < 0)) break;
    // A whole move is exact while the same planes hold; else it goes to the least cost on its line.
    bool same = true;
    for (std::uint32_t i = 0; i < planes.count; ++i) {
      planes.climb[i] = planes.n[i].dot(move);
      same = same && (planes.left[i] > 0) == (planes.left[i] > planes.climb[i]);
    }
    e += (same ? 1 : planes.bestLength(slope, kCornerSoftness * move.squaredNorm())) * move;
    if (same) break;
  }
  return (1 + kCornerSoftness) * e;
}

}  // namespace hapticd
