#include <cmath>

#include "rt/geometry/prisms.h"

namespace hapticd {
namespace {

// As the vector instructions: the second operand if they are equal or one is not a number.
float least(float a, float b) noexcept { return a < b ? a : b; }
float greatest(float a, float b) noexcept { return a > b ? a : b; }

float above(const float (&normal)[3][kPrismWidth], const float* offset, int i, const float* x) noexcept {
  return (normal[0][i] * x[0] + normal[1][i] * x[1]) + (normal[2][i] * x[2] - offset[i]);
}

bool reaches(const PrismBlock& block, int i, const PrismSweep& sweep) noexcept {
  const float at_a = above(block.normal, block.offset, i, sweep.a);
  const float at_b = sweep.still ? at_a : above(block.normal, block.offset, i, sweep.b);
  const float low = least(at_a, at_b), high = greatest(at_a, at_b);
  const float apart = greatest(greatest(low, 0.0F - high), 0.0F);
  float beyond = 0;
  for (int k = 0; k < 3; ++k) {
    const float side_a = above(block.side[k], block.side_offset[k], i, sweep.a);
    const float side_b = sweep.still ? side_a : above(block.side[k], block.side_offset[k], i, sweep.b);
    beyond = greatest(least(side_a, side_b), beyond);
  }
  return apart * apart + beyond * beyond <= sweep.radius_squared && high >= 0.0F - sweep.behind;
}

struct Vec {
  float x, y, z;
};

Vec minus(const Vec& a, const Vec& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec times(const Vec& a, float s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
float dot(const Vec& a, const Vec& b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
Vec cross(const Vec& a, const Vec& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

void put(const Vec& n, float offset, float far, float (&normal)[3][kPrismWidth], float* offsets, int i) noexcept {
  normal[0][i] = n.x;
  normal[1][i] = n.y;
  normal[2][i] = n.z;
  offsets[i] = greatest(least(offset, far), 0.0F - far);
}

bool make(const PrismCorners& corners, int i, float radius, PrismBlock& block) noexcept {
  Vec v[3], edge[3];
  for (int k = 0; k < 3; ++k) v[k] = {corners.v[k][0][i], corners.v[k][1][i], corners.v[k][2][i]};
  for (int k = 0; k < 3; ++k) edge[k] = minus(v[(k + 1) % 3], v[k]);
  const float far = kPrismFar * radius;
  const Vec up = cross(edge[0], edge[1]);
  const float area = std::sqrt(dot(up, up));
  const Vec n = times(up, 1.0F / area);
  put(n, dot(n, v[0]), far, block.normal, block.offset, i);
  float longest = 0;
  for (int k = 0; k < 3; ++k) {
    const float squared = dot(edge[k], edge[k]);
    const Vec side = times(cross(edge[k], n), 1.0F / std::sqrt(squared));
    put(side, dot(side, v[k]), far, block.side[k], block.side_offset[k], i);
    longest = greatest(squared, longest);
  }
  return !(longest * (radius + std::sqrt(longest)) <= kPrismRough * radius * area);
}

}  // namespace

std::uint32_t makePrismsPortable(const PrismCorners& corners, float radius, PrismBlock& block) noexcept {
  std::uint32_t rough = 0;
  for (int i = 0; i < kPrismWidth; ++i) rough |= static_cast<std::uint32_t>(make(corners, i, radius, block)) << i;
  return rough;
}

void reachPrismsPortable(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                         std::uint8_t* mask) noexcept {
  for (; blocks != 0; blocks &= blocks - 1) {
    const int k = __builtin_ctzll(blocks);
    unsigned bits = 0;
    for (int i = 0; i < kPrismWidth; ++i) bits |= static_cast<unsigned>(reaches(block[k], i, sweep)) << i;
    mask[k] = static_cast<std::uint8_t>(bits);
  }
}

}  // namespace hapticd
