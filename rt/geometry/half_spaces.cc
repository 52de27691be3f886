#include "rt/geometry/half_spaces.h"

#include <bit>
#include <limits>

namespace hapticd {
namespace {

/** Sets of up to four planes: first one each, then two, then three. Four planes meet in no point. */
constexpr std::uint32_t kSets[] = {1, 2, 4, 8, 3, 5, 6, 9, 10, 12, 7, 11, 13, 14};
static_assert(kMaxHalfSpaces == 4);

}  // namespace

bool nearestOnPlanes(const HalfSpace* planes, std::uint32_t mask, Vec3& x) HD_RT {
  // One plane after the other, each step along the part of its normal that keeps the planes before it.
  constexpr double kParallel = 1e-12;  // Sine of the angle below which two planes have no line in common.
  if (isOneBit(mask)) {
    const HalfSpace& plane = planes[std::countr_zero(mask)];
    x -= plane.normal * (plane.height(x) / plane.normal.squaredNorm());
    return true;
  }
  Vec3 basis[3];
  int rank = 0;
  Vec3 result = x;
  for (std::uint32_t i = 0; mask >> i; ++i) {
    if (!(mask >> i & 1u)) continue;
    if (rank == 3) return false;
    const Vec3& n = planes[i].normal;
    Vec3 along = n;
    for (int twice = 0; twice < 2; ++twice) {  // The second pass restores what cancellation took from the first.
      for (int j = 0; j < rank; ++j) along -= basis[j] * basis[j].dot(along);
    }
    const double length = along.norm();
    if (length < kParallel) return false;
    basis[rank] = along / length;
    result -= basis[rank] * (planes[i].height(result) / basis[rank].dot(n));
    ++rank;
  }
  x = result;
  return true;
}

bool nearestInside(const HalfSpace* planes, int count, double tolerance, Vec3& x, std::uint32_t& active) HD_RT {
  const auto inside = [&](const Vec3& y) {
    for (int i = 0; i < count; ++i) {
      if (!(planes[i].height(y) >= -tolerance)) return false;
    }
    return true;
  };
  if (inside(x)) {
    active = 0;
    return true;
  }
  if (count == 1) {
    Vec3 y = x;
    if (!nearestOnPlanes(planes, 1, y) || !inside(y)) return false;
    x = y;
    active = 1;
    return true;
  }
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t best_mask = 0;
  Vec3 nearest = x;
  for (const std::uint32_t mask : kSets) {
    if (mask >> count != 0) continue;
    const bool single = isOneBit(mask);
    // The half-spaces are convex: the foot on one plane behind which x lies, if it is inside all others, is the
    // nearest.
    if (best_mask != 0 && isOneBit(best_mask) && !single) break;
    if (single && planes[std::countr_zero(mask)].height(x) >= 0) continue;
    Vec3 y = x;
    if (!nearestOnPlanes(planes, mask, y) || !inside(y)) continue;
    const double distance = (y - x).squaredNorm();
    if (distance < best) {
      best = distance;
      best_mask = mask;
      nearest = y;
    }
  }
  if (best == std::numeric_limits<double>::infinity()) return false;
  x = nearest;
  active = best_mask;
  return true;
}

}  // namespace hapticd
