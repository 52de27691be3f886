#include "rt/geometry/tree/prisms.h"

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
  const float left = sweep.radius_squared * block.squared[i] - apart * apart;
  if (!(left >= 0) || !(high >= 0 || high * high <= sweep.behind_squared * block.squared[i])) return false;
  for (int k = 0; k < 3; ++k) {
    const float side_a = above(block.side[k], block.side_offset[k], i, sweep.a);
    const float side_b = sweep.still ? side_a : above(block.side[k], block.side_offset[k], i, sweep.b);
    const float beyond = greatest(least(side_a, side_b), 0.0F);
    if (!(beyond * beyond <= left * block.side_squared[k][i])) return false;
  }
  return true;
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

void put(const Vec& n, float offset, float (&normal)[3][kPrismWidth], float* offsets, int i) noexcept {
  normal[0][i] = n.x;
  normal[1][i] = n.y;
  normal[2][i] = n.z;
  offsets[i] = offset;
}

bool make(const float* corners, const PrismFrame& frame, int i, PrismBlock& block) noexcept {
  const Vec origin{frame.origin[0], frame.origin[1], frame.origin[2]};
  Vec v[3], edge[3];
  for (int k = 0; k < 3; ++k)
    v[k] = times(minus({corners[3 * k], corners[3 * k + 1], corners[3 * k + 2]}, origin), frame.inverse);
  for (int k = 0; k < 3; ++k) edge[k] = minus(v[(k + 1) % 3], v[k]);
  const Vec n = cross(edge[0], edge[1]);
  const float squared = dot(n, n);
  put(n, dot(n, v[0]), block.normal, block.offset, i);
  block.squared[i] = squared;
  float longest = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec side = cross(edge[k], n);
    put(side, dot(side, v[k]), block.side[k], block.side_offset[k], i);
    block.side_squared[k][i] = dot(edge[k], edge[k]);  // At right angles to the normal: this times its square.
    longest = greatest(block.side_squared[k][i], longest);
  }
  const float size = (longest * longest) * (2 + 2 * longest);
  return !(size <= kPrismRough * squared && squared >= kPrismSmall);
}

}  // namespace

std::uint32_t makePrismsPortable(const float* corners, std::uint32_t count, const PrismFrame& frame,
                                 PrismBlock& block) noexcept {
  std::uint32_t rough = 0;
  for (std::uint32_t i = 0; i < kPrismWidth; ++i) {
    const float* const triangle = corners + 9 * (i < count ? i : count - 1);
    rough |= static_cast<std::uint32_t>(make(triangle, frame, static_cast<int>(i), block)) << i;
  }
  return rough;
}

PrismsReached reachPrismsPortable(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                                  std::uint32_t* triangles) noexcept {
  const auto looked_at = static_cast<std::uint32_t>(__builtin_popcountll(blocks));
  std::uint32_t count = 0;
  for (; blocks != 0; blocks &= blocks - 1) {
    const PrismBlock& each = block[__builtin_ctzll(blocks)];
    for (int i = 0; i < kPrismWidth; ++i) {
      if ((each.used >> i & 1u) != 0 && reaches(each, i, sweep))
        triangles[count++] = each.first + static_cast<std::uint32_t>(i);
    }
  }
  return {looked_at, count};
}

}  // namespace hapticd
