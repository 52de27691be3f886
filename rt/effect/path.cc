#include "rt/effect/path.h"

#include <algorithm>

namespace hapticd {
namespace {

constexpr double kPlaceRounding = 1e-12;  ///< More than that of a place 100 m away [m].

Vec3 pointOf(const EffectParameters& path, std::uint32_t i) HD_RT {
  return Vec3(path.path[i][0], path.path[i][1], path.path[i][2]);
}

Vec3 onSpan(const Vec3 (&b)[4], double t) HD_RT {
  const double s = 1 - t;
  return s * s * s * b[0] + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
}

}  // namespace

void spanOfPath(const EffectParameters& path, std::uint32_t i, Vec3 (&control)[4]) HD_RT {
  const std::uint32_t last = path.points - 1;
  const Vec3 a = pointOf(path, i), b = pointOf(path, i + 1);
  const bool closed = last > 1 && pointOf(path, 0) == pointOf(path, last);
  // At an open end the curve is as if the next point's way back were mirrored: two points make a line.
  const Vec3 before = i > 0 ? pointOf(path, i - 1) : closed ? pointOf(path, last - 1) : Vec3(2 * a - b);
  const Vec3 after = i + 1 < last ? pointOf(path, i + 2) : closed ? pointOf(path, 1) : Vec3(2 * b - a);
  control[0] = a;
  control[1] = a + (b - before) / 6;
  control[2] = b - (after - a) / 6;
  control[3] = b;
}

bool nearestOnPath(const EffectParameters& path, const Vec3& x, double reach, PathPlace& place) HD_RT {
  // The curve goes through its points: none of it that is farther than the nearest of them need be looked at.
  double best = reach * reach, to_point = best;
  for (std::uint32_t i = 0; i < path.points; ++i) to_point = std::min(to_point, (x - pointOf(path, i)).squaredNorm());
  const double looked_at = std::sqrt(to_point) + kPlaceRounding;
  bool found = false;
  for (std::uint32_t i = 0; i + 1 < path.points; ++i) {
    Vec3 b[4];
    spanOfPath(path, i, b);
    const Vec3 middle = 0.5 * (b[0] + b[3]);
    double size = 0;
    for (const Vec3& corner : b) size = std::max(size, (corner - middle).squaredNorm());
    const double near = (x - middle).norm() - std::sqrt(size);
    if (near > looked_at || (near > 0 && near * near > best)) continue;
    Vec3 from = b[0];
    for (int k = 1; k <= kChordsPerSpan; ++k) {
      const Vec3 to = k == kChordsPerSpan ? b[3] : onSpan(b, static_cast<double>(k) / kChordsPerSpan);
      const Vec3 chord = to - from;
      const double squared = chord.squaredNorm();
      const double along = squared > 0 ? std::clamp(chord.dot(x - from) / squared, 0.0, 1.0) : 0.0;
      const Vec3 point = from + along * chord;
      const double distance = (x - point).squaredNorm();
      if (distance < best) {
        best = distance;
        place.point = point;
        place.tangent = squared > 0 ? Vec3(chord / std::sqrt(squared)) : Vec3(Vec3::Zero());
        found = true;
      }
      from = to;
    }
  }
  return found;
}

}  // namespace hapticd
