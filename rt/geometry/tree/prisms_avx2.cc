// Compiled with AVX2: nothing may be included here that has inline code of its own.
#include <immintrin.h>

#include "rt/geometry/tree/prisms.h"

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

void put(const Point& n, __m256 offset, float (&normal)[3][kPrismWidth], float* offsets) noexcept {
  _mm256_storeu_ps(normal[0], n.x);
  _mm256_storeu_ps(normal[1], n.y);
  _mm256_storeu_ps(normal[2], n.z);
  _mm256_storeu_ps(offsets, offset);
}

/** Nine coordinates of each of eight triangles: coordinate by coordinate. */
void transposed(const float* const (&row)[kPrismWidth], __m256 (&column)[9]) noexcept {
  __m256 r[8], pair[8], four[8];
  for (int i = 0; i < 8; ++i) r[i] = _mm256_loadu_ps(row[i]);
  for (int i = 0; i < 4; ++i) {
    pair[2 * i] = _mm256_unpacklo_ps(r[2 * i], r[2 * i + 1]);
    pair[2 * i + 1] = _mm256_unpackhi_ps(r[2 * i], r[2 * i + 1]);
  }
  for (int i = 0; i < 8; i += 4) {
    four[i] = _mm256_shuffle_ps(pair[i], pair[i + 2], 0x44);
    four[i + 1] = _mm256_shuffle_ps(pair[i], pair[i + 2], 0xee);
    four[i + 2] = _mm256_shuffle_ps(pair[i + 1], pair[i + 3], 0x44);
    four[i + 3] = _mm256_shuffle_ps(pair[i + 1], pair[i + 3], 0xee);
  }
  for (int i = 0; i < 4; ++i) {
    column[i] = _mm256_permute2f128_ps(four[i], four[i + 4], 0x20);
    column[i + 4] = _mm256_permute2f128_ps(four[i], four[i + 4], 0x31);
  }
  column[8] = _mm256_setr_ps(row[0][8], row[1][8], row[2][8], row[3][8], row[4][8], row[5][8], row[6][8], row[7][8]);
}

/** A sweep in all lanes. */
struct Spread {
  Point a, b;
  __m256 radius_squared, behind_squared;
};

/** Bit i: triangle i may be met, judged by its plane; `left`: of the radius' square, what its sides may be away. */
template <bool kStill>
std::uint32_t planes(const PrismBlock& p, const Spread& s, __m256& left) noexcept {
  const __m256 zero = _mm256_setzero_ps(), squared = _mm256_load_ps(p.squared);
  const __m256 at_a = above(p.normal, p.offset, s.a), at_b = kStill ? at_a : above(p.normal, p.offset, s.b);
  const __m256 low = kStill ? at_a : _mm256_min_ps(at_a, at_b), high = kStill ? at_a : _mm256_max_ps(at_a, at_b);
  const __m256 apart = _mm256_max_ps(_mm256_max_ps(low, _mm256_sub_ps(zero, high)), zero);
  left = _mm256_sub_ps(_mm256_mul_ps(s.radius_squared, squared), _mm256_mul_ps(apart, apart));
  const __m256 close = _mm256_cmp_ps(_mm256_mul_ps(high, high), _mm256_mul_ps(s.behind_squared, squared), _CMP_LE_OQ);
  const __m256 front = _mm256_or_ps(_mm256_cmp_ps(high, zero, _CMP_GE_OQ), close);
  return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_and_ps(front, _mm256_cmp_ps(left, zero, _CMP_GE_OQ))));
}

/** The same by the planes on its edges. */
template <bool kStill>
std::uint32_t sides(const PrismBlock& p, const Spread& s, __m256 left) noexcept {
  __m256 met[3];
  for (int i = 0; i < 3; ++i) {
    const __m256 at_a = above(p.side[i], p.side_offset[i], s.a);
    const __m256 low = kStill ? at_a : _mm256_min_ps(at_a, above(p.side[i], p.side_offset[i], s.b));
    const __m256 beyond = _mm256_max_ps(low, _mm256_setzero_ps());
    const __m256 most = _mm256_mul_ps(left, _mm256_load_ps(p.side_squared[i]));
    met[i] = _mm256_cmp_ps(_mm256_mul_ps(beyond, beyond), most, _CMP_LE_OQ);
  }
  return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_and_ps(met[0], _mm256_and_ps(met[1], met[2]))));
}

/** Of each mask the numbers of its bits, a byte each. */
struct BitNumbers {
  std::uint64_t of[1u << kPrismWidth];
};

constexpr BitNumbers bitNumbers() noexcept {
  BitNumbers numbers{};
  for (unsigned mask = 0; mask < 1u << kPrismWidth; ++mask) {
    unsigned shift = 0;
    for (unsigned bit = 0; bit < kPrismWidth; ++bit) {
      if ((mask >> bit & 1u) == 0) continue;
      numbers.of[mask] |= static_cast<std::uint64_t>(bit) << shift;
      shift += 8;
    }
  }
  return numbers;
}

constexpr BitNumbers kBitNumbers = bitNumbers();

template <bool kStill>
PrismsReached reach(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                    std::uint32_t* triangles) noexcept {
  const Spread s{spread(sweep.a), spread(sweep.b), _mm256_set1_ps(sweep.radius_squared),
                 _mm256_set1_ps(sweep.behind_squared)};
  const auto looked_at = static_cast<std::uint32_t>(__builtin_popcountll(blocks));
  __m256 left[kPrismBlocks];
  std::uint32_t near[kPrismBlocks];
  std::uint64_t rest = 0;
  for (; blocks != 0; blocks &= blocks - 1) {
    const int k = __builtin_ctzll(blocks);
    near[k] = planes<kStill>(block[k], s, left[k]) & block[k].used;
    rest |= static_cast<std::uint64_t>(near[k] != 0) << k;
  }
  std::uint32_t count = 0;
  for (; rest != 0; rest &= rest - 1) {
    const int k = __builtin_ctzll(rest);
    const std::uint32_t met = near[k] & sides<kStill>(block[k], s, left[k]);
    const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(&kBitNumbers.of[met]));
    const __m256i first = _mm256_set1_epi32(static_cast<int>(block[k].first));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(triangles + count),
                        _mm256_add_epi32(_mm256_cvtepu8_epi32(bytes), first));
    count += static_cast<std::uint32_t>(__builtin_popcount(met));
  }
  return {looked_at, count};
}

}  // namespace

std::uint32_t makePrismsAvx2(const float* corners, std::uint32_t count, const PrismFrame& frame,
                             PrismBlock& block) noexcept {
  const float* row[kPrismWidth];
  for (std::uint32_t i = 0; i < kPrismWidth; ++i) row[i] = corners + 9 * (i < count ? i : count - 1);
  __m256 x[9];
  transposed(row, x);
  const Point origin = spread(frame.origin);
  const __m256 inverse = _mm256_set1_ps(frame.inverse);
  Point v[3], edge[3];
  for (int k = 0; k < 3; ++k) v[k] = times(minus({x[3 * k], x[3 * k + 1], x[3 * k + 2]}, origin), inverse);
  for (int k = 0; k < 3; ++k) edge[k] = minus(v[(k + 1) % 3], v[k]);
  const Point n = cross(edge[0], edge[1]);
  const __m256 squared = dot(n, n);
  put(n, dot(n, v[0]), block.normal, block.offset);
  _mm256_storeu_ps(block.squared, squared);
  __m256 longest = _mm256_setzero_ps();
  for (int k = 0; k < 3; ++k) {
    const Point side = cross(edge[k], n);
    put(side, dot(side, v[k]), block.side[k], block.side_offset[k]);
    const __m256 along = dot(edge[k], edge[k]);  // At right angles to the normal: this times its square.
    _mm256_storeu_ps(block.side_squared[k], along);
    longest = _mm256_max_ps(along, longest);
  }
  const __m256 two = _mm256_set1_ps(2);
  const __m256 size = _mm256_mul_ps(_mm256_mul_ps(longest, longest), _mm256_add_ps(two, _mm256_mul_ps(two, longest)));
  const __m256 fine =
      _mm256_and_ps(_mm256_cmp_ps(size, _mm256_mul_ps(_mm256_set1_ps(kPrismRough), squared), _CMP_LE_OQ),
                    _mm256_cmp_ps(squared, _mm256_set1_ps(kPrismSmall), _CMP_GE_OQ));
  return ~static_cast<std::uint32_t>(_mm256_movemask_ps(fine)) & 0xffu;
}

PrismsReached reachPrismsAvx2(const PrismBlock* block, std::uint64_t blocks, const PrismSweep& sweep,
                              std::uint32_t* triangles) noexcept {
  return sweep.still ? reach<true>(block, blocks, sweep, triangles) : reach<false>(block, blocks, sweep, triangles);
}

}  // namespace hapticd
