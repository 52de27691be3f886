#include "rt/geometry/half_spaces.h"

#include <bit>
#include <limits>

namespace hapticd {

bool nearestOnPlanes(const HalfSpace* planes, std::uint32_t mask, Vec3& x) HD_RT {
  // One plane after the other, each step along the part of its normal that keeps the planes before it.
  constexpr double kParallel = 1e-12;  // Sine of the angle below which two planes have no line in common.
  if (std::has_single_bit(mask)) {
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
  if (count == 1) {
    Vec3 y = x;
    const bool free = inside(x);
    if (!free && (!nearestOnPlanes(planes, 1, y) || !inside(y))) return false;
    x = y;
    active = free ? 0 : 1;
    return true;
  }
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t best_mask = 0;
  Vec3 nearest = x;
  for (std::uint32_t mask = 0; mask < (1u << count); ++mask) {
    if (mask == 15) continue;  // Four planes meet in no point.
    Vec3 y = x;
    if (!nearestOnPlanes(planes, mask, y) || !inside(y)) continue;
    const double distance = (y - x).squaredNorm();
    if (distance < best) {
      best = distance;
      best_mask = mask;
      nearest = y;
    }
    if (mask == 0) break;
  }
  if (best == std::numeric_limits<double>::infinity()) return false;
  x = nearest;
  active = best_mask;
  return true;
}

}  // namespace hapticd
