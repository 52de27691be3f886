#include "rt/render/proxy/press.h"

#include <algorithm>

namespace hapticd {
namespace {

/**
 * Those left, seen across the ones before, of which the last is as stiff as `before`. Bounded: each call has one
 * surface less.
 */
Vec3 pressWith(const Pressing* left, int count, const Vec3& up, double before) HD_RT {
  double all = 0;
  for (int i = 0; i < count; ++i) all += left[i].push;
  if (!(all > 0)) return before * up;
  Vec3 force = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    if (!(left[i].push > 0)) continue;
    const Vec3& n = left[i].normal;
    const Vec3 along = n.dot(up) * n;
    Pressing rest[kMaxPressing];
    int others = 0;
    for (int j = 0; j < count; ++j) {
      const Vec3 across = left[j].normal - left[j].normal.dot(n) * n;
      const double length = across.norm();
      if (j != i && length > 0) rest[others++] = {across / length, left[j].push * length, left[j].stiffness};
    }
    force += left[i].push / all * (left[i].stiffness * along + pressWith(rest, others, up - along, left[i].stiffness));
  }
  return force;
}

}  // namespace

Vec3 press(std::span<const Pressing> surfaces, const Vec3& up) HD_RT {
  return pressWith(surfaces.data(), std::min(static_cast<int>(surfaces.size()), kMaxPressing), up, 0);
}

}  // namespace hapticd
