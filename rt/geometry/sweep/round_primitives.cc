// A ball against box and cylinder: the solids grown by its radius, with round edges.
#include <algorithm>
#include <cmath>

#include "rt/geometry/sweep/first_touch.h"

namespace hapticd {
namespace {

template <class Foot>
bool sweepRound(const Sweep& sweep, SweepHit& hit, Foot&& foot) HD_RT {
  double t = 0;
  Vec3 normal;
  if (!firstTouch(sweep, roundingOf(sweep), hit.t, foot, t, normal) || t >= hit.t) return false;
  const double offset = normal.dot(foot(Vec3(sweep.a + t * sweep.d))) + sweep.radius;
  hit = SweepHit{};
  hit.t = t;
  hit.normal = normal;
  hit.offset = offset;
  hit.height = normal.dot(sweep.a) - offset;
  return true;
}

}  // namespace

bool sweepRoundBox(const Vec3& half, const Sweep& sweep, SweepHit& hit) HD_RT {
  if (!sweepRound(sweep, hit, [&](const Vec3& x) { return Vec3(x.cwiseMax(-half).cwiseMin(half)); })) return false;
  // Faces as without a radius; then 3 x 3 x 3 places, of which the edges and vertices are used.
  std::uint32_t place = 0, sides = 0, face = 0;
  for (int i = 0; i < 3; ++i) {
    const bool beside = hit.normal[i] != 0;
    const std::uint32_t side = hit.normal[i] > 0 ? 0 : 1;
    place = 3 * place + (beside ? side : 2);
    if (beside) face = 2 * static_cast<std::uint32_t>(i) + side;
    sides += beside ? 1 : 0;
  }
  hit.feature = sides == 1 ? face : 6 + place;
  hit.kind = sides == 1 ? FeatureKind::kFace : (sides == 2 ? FeatureKind::kEdge : FeatureKind::kVertex);
  return true;
}

bool sweepRoundCylinder(double radius, double half, const Sweep& sweep, SweepHit& hit) HD_RT {
  const auto foot = [&](const Vec3& x) {
    const double from_axis = x.head<2>().norm();
    const double in = from_axis > radius ? radius / from_axis : 1.0;
    return Vec3(x.x() * in, x.y() * in, std::clamp(x.z(), -half, half));
  };
  if (!sweepRound(sweep, hit, foot)) return false;
  const bool top = hit.normal.z() > 0, side = hit.normal.x() != 0 || hit.normal.y() != 0;
  hit.feature = hit.normal.z() == 0 ? 0 : (top ? 1 : 2) + (side ? 2 : 0);  // side, caps, rims
  hit.kind = hit.feature > 2 ? FeatureKind::kEdge : FeatureKind::kFace;
  return true;
}

}  // namespace hapticd
