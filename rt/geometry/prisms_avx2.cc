// Compiled with AVX2: nothing may be included here that has inline code of its own.
#include <immintrin.h>

#include "rt/geometry/prisms.h"

namespace hapticd {
namespace {

struct Point {
  __m256 x, y, z;
};

Point spread(const float (&x)[3]) noexcept {
  return {_mm256_set1_ps(x[0]), _mm256_set1_ps(x[1]), _mm256_set1_ps(x[2])};
}

__m256 above(const float (&normal)[3][kPrismWidth], const float* offset, const Point& x) noexcept {
  const __m256 xy =
      _mm256_add_ps(_mm256_mul_ps(_mm256_loadu_ps(normal[0]), x.x), _mm256_mul_ps(_mm256_loadu_ps(normal[1]), x.y));
  return _mm256_add_ps(xy, _mm256_sub_ps(_mm256_mul_ps(_mm256_loadu_ps(normal[2]), x.z), _mm256_loadu_ps(offset)));
}

Point minus(const Point& a, const Point& b) noexcept {
  return {_mm256_sub_ps(a.x, b.x), _mm256_sub_ps(a.y, b.y), _mm256_sub_ps(a.z, b.z)};
}

Point times(const Point& a, __m256 s) noexcept {
  return {_mm256_mul_ps(a.x, s), _mm256_mul_ps(a.y, s), _mm256_mul_ps(a.z, s)};
}

__m256 dot(const Point& a, const Point& b) noexcept {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a.x, b.x), _mm256_mul_ps(a.y, b.y)), _mm256_mul_ps(a.z, b.z));
}

Point cross(const Point& a, const Point& b) noexcept {
  return {_mm256_sub_ps(_mm256_mul_ps(a.y, b.z), _mm256_mul_ps(a.z, b.y)),
          _mm256_sub_ps(_mm256_mul_ps(a.z, b.x), _mm256_mul_ps(a.x, b.z)),
          _mm256_sub_ps(_mm256_mul_ps(a.x, b.y), _mm256_mul_ps(a.y, b.x))};
}

void put(const Point& n, __m256 offset, __m256 far, float (&normal)[3][kPrismWidth], float* offsets) noexcept {
  _mm256_storeu_ps(normal[0], n.x);
  _mm256_storeu_ps(normal[1], n.y);
  _mm256_storeu_ps(normal[2], n.z);
  _mm256_storeu_ps(offsets, _mm256_max_ps(_mm256_min_ps(offset, far), _mm256_sub_ps(_mm256_setzero_ps(), far)));
}

template <bool kStill>
void reach(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep, std::uint8_t* mask) noexcept {
  const Point a = spread(sweep.a), b = spread(sweep.b);
  const __m256 zero = _mm256_setzero_ps(), squared = _mm256_set1_ps(sweep.radius_squared);
  const __m256 behind = _mm256_set1_ps(0.0F - sweep.behind);
  for (; blocks != 0; blocks &= blocks - 1) {
    const int k = __builtin_ctzll(blocks);
    const PrismBlock& p = block[k];
    const __m256 at_a = above(p.normal, p.offset, a), at_b = kStill ? at_a : above(p.normal, p.offset, b);
    const __m256 low = _mm256_min_ps(at_a, at_b), high = _mm256_max_ps(at_a, at_b);
    const __m256 apart = _mm256_max_ps(_mm256_max_ps(low, _mm256_sub_ps(zero, high)), zero);
    const __m256 front = _mm256_cmp_ps(high, behind, _CMP_GE_OQ);
    const __m256 apart2 = _mm256_mul_ps(apart, apart);
    const __m256 level = _mm256_and_ps(front, _mm256_cmp_ps(apart2, squared, _CMP_LE_OQ));
    if (_mm256_movemask_ps(level) == 0) {  // Most blocks are done with their planes.
      mask[k] = 0;
      continue;
    }
    __m256 beyond = zero;
    for (int i = 0; i < 3; ++i) {
      const __m256 side_a = above(p.side[i], p.side_offset[i], a);
      const __m256 side_b = kStill ? side_a : above(p.side[i], p.side_offset[i], b);
      beyond = _mm256_max_ps(_mm256_min_ps(side_a, side_b), beyond);
    }
    const __m256 distance2 = _mm256_add_ps(apart2, _mm256_mul_ps(beyond, beyond));
    const __m256 met = _mm256_and_ps(front, _mm256_cmp_ps(distance2, squared, _CMP_LE_OQ));
    mask[k] = static_cast<std::uint8_t>(_mm256_movemask_ps(met));
  }
}

}  // namespace

std::uint32_t makePrismsAvx2(const PrismCorners& corners, float radius, PrismBlock& block) noexcept {
  Point v[3], edge[3];
  for (int k = 0; k < 3; ++k) {
    v[k] = {_mm256_loadu_ps(corners.v[k][0]), _mm256_loadu_ps(corners.v[k][1]), _mm256_loadu_ps(corners.v[k][2])};
  }
  for (int k = 0; k < 3; ++k) edge[k] = minus(v[(k + 1) % 3], v[k]);
  const __m256 one = _mm256_set1_ps(1), far = _mm256_set1_ps(kPrismFar * radius);
  const Point up = cross(edge[0], edge[1]);
  const __m256 area = _mm256_sqrt_ps(dot(up, up));
  const Point n = times(up, _mm256_div_ps(one, area));
  put(n, dot(n, v[0]), far, block.normal, block.offset);
  __m256 longest = _mm256_setzero_ps();
  for (int k = 0; k < 3; ++k) {
    const __m256 squared = dot(edge[k], edge[k]);
    const Point side = times(cross(edge[k], n), _mm256_div_ps(one, _mm256_sqrt_ps(squared)));
    put(side, dot(side, v[k]), far, block.side[k], block.side_offset[k]);
    longest = _mm256_max_ps(squared, longest);
  }
  const __m256 reach = _mm256_add_ps(_mm256_set1_ps(radius), _mm256_sqrt_ps(longest));
  const __m256 most = _mm256_mul_ps(_mm256_set1_ps(kPrismRough * radius), area);
  const __m256 fine = _mm256_cmp_ps(_mm256_mul_ps(longest, reach), most, _CMP_LE_OQ);
  return ~static_cast<std::uint32_t>(_mm256_movemask_ps(fine)) & 0xffu;
}

void reachPrismsAvx2(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                     std::uint8_t* mask) noexcept {
  if (sweep.still) {
    reach<true>(block, blocks, sweep, mask);
  } else {
    reach<false>(block, blocks, sweep, mask);
  }
}

}  // namespace hapticd
