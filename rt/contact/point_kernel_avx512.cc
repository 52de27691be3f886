// Compiled with AVX-512: nothing may be included here that has inline code of its own.
#include <immintrin.h>

#include "rt/contact/point_kernel.h"

#define HD_LANES __attribute__((always_inline)) inline
#define HD_LANES_LAMBDA __attribute__((always_inline))

namespace {

using F = __m512;
using I = __m512i;
using M = __mmask16;

HD_LANES F all(float x) { return _mm512_set1_ps(x); }
HD_LANES F zeroOf() { return _mm512_setzero_ps(); }
HD_LANES I allInt(int x) { return _mm512_set1_epi32(x); }
HD_LANES F load(const float* p) { return _mm512_loadu_ps(p); }
HD_LANES void store(float* p, F x) { _mm512_storeu_ps(p, x); }
HD_LANES F add(F a, F b) { return _mm512_add_ps(a, b); }
HD_LANES F sub(F a, F b) { return _mm512_sub_ps(a, b); }
HD_LANES F mul(F a, F b) { return _mm512_mul_ps(a, b); }
HD_LANES F quotient(F a, F b) { return _mm512_div_ps(a, b); }
HD_LANES F least(F a, F b) { return _mm512_min_ps(a, b); }
HD_LANES F greatest(F a, F b) { return _mm512_max_ps(a, b); }
HD_LANES F root(F a) { return _mm512_sqrt_ps(a); }
HD_LANES M less(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
HD_LANES M lessEqual(F a, F b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
HD_LANES F choose(M m, F yes, F no) { return _mm512_mask_blend_ps(m, no, yes); }
HD_LANES I toInt(F a) { return _mm512_cvttps_epi32(a); }
HD_LANES F toFloat(I a) { return _mm512_cvtepi32_ps(a); }
HD_LANES I addInt(I a, I b) { return _mm512_add_epi32(a, b); }
HD_LANES I subInt(I a, I b) { return _mm512_sub_epi32(a, b); }
HD_LANES I mulInt(I a, I b) { return _mm512_mullo_epi32(a, b); }
HD_LANES I andInt(I a, I b) { return _mm512_and_si512(a, b); }
HD_LANES I orInt(I a, I b) { return _mm512_or_si512(a, b); }
HD_LANES I shiftRight3(I a) { return _mm512_srli_epi32(a, 3); }
HD_LANES I shiftRight16(I a) { return _mm512_srai_epi32(a, 16); }
HD_LANES I shiftLeft16(I a) { return _mm512_slli_epi32(a, 16); }
HD_LANES I shiftedLeft(I a, int by) { return _mm512_sll_epi32(a, _mm_cvtsi32_si128(by)); }
/** Four words, again and again: lanes that have a bit of theirs. */
HD_LANES M hasBit(const unsigned* words, I bit) {
  const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(words));
  return _mm512_test_epi32_mask(_mm512_broadcast_i32x4(four), bit);
}
HD_LANES M equalInt(I a, I b) { return _mm512_cmpeq_epi32_mask(a, b); }
HD_LANES I masked(M m, I a) { return _mm512_maskz_mov_epi32(m, a); }
HD_LANES I pairs(I values, I weights) { return _mm512_madd_epi16(values, weights); }
/** Sixteen indices in memory: read from there one by one. To take a register apart costs three times as much. */
struct Lanes16 {
  alignas(64) int i[16];
};
HD_LANES void keep(Lanes16& at, I x) { _mm512_store_si512(at.i, x); }
HD_LANES __m128i four(const unsigned* base, const int* at) {
  const __m128i x = _mm_cvtsi32_si128(static_cast<int>(base[at[0]]));
  const __m128i y = _mm_insert_epi32(x, static_cast<int>(base[at[1]]), 1);
  return _mm_insert_epi32(_mm_insert_epi32(y, static_cast<int>(base[at[2]]), 2), static_cast<int>(base[at[3]]), 3);
}
/** A gather instruction takes 19 cycles, this 12 (Zen 5). */
HD_LANES I gatherKept(const unsigned* base, const Lanes16& at) {
  const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(four(base, at.i)), four(base, at.i + 4), 1);
  const __m256i high = _mm256_inserti128_si256(_mm256_castsi128_si256(four(base, at.i + 8)), four(base, at.i + 12), 1);
  return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
}
HD_LANES I gather(const unsigned* base, I index) { return _mm512_i32gather_epi32(index, base, 4); }
HD_LANES I gatherPairs(const short* base, I index) { return _mm512_i32gather_epi32(index, base, 2); }
// 32 bytes from the highest place of a voxel in the upper layer end within the brick.
static_assert(7 + 9 * 7 + 81 * 8 + 16 <= 736);
// 32 bytes hold a point's two values along x and the two beside them in the next row:
// one load a layer, and the words are sorted in registers.
struct Corners {
  I v00, v10, v01, v11;
};
HD_LANES __m512i twoLanes(const short* values, const int* at) {
  const auto* low = reinterpret_cast<const __m256i*>(values + at[0]);
  const auto* high = reinterpret_cast<const __m256i*>(values + at[1]);
  return _mm512_inserti64x4(_mm512_castsi256_si512(_mm256_loadu_si256(low)), _mm256_loadu_si256(high), 1);
}
/** Of eight lanes: values 0 and 1 in the lower half, 9 and 10 in the upper. */
HD_LANES __m512i eightLanes(const short* values, const int* at) {
  const __m512i order = _mm512_set_epi16(58, 57, 42, 41, 26, 25, 10, 9, 58, 57, 42, 41, 26, 25, 10, 9,  //
                                         49, 48, 33, 32, 17, 16, 1, 0, 49, 48, 33, 32, 17, 16, 1, 0);
  return _mm512_mask_blend_epi32(0xf0f0,
                                 _mm512_permutex2var_epi16(twoLanes(values, at), order, twoLanes(values, at + 2)),
                                 _mm512_permutex2var_epi16(twoLanes(values, at + 4), order, twoLanes(values, at + 6)));
}
HD_LANES void layerOf(const short* values, const int* at, I& row, I& next) {
  const __m512i a = eightLanes(values, at), b = eightLanes(values, at + 8);
  row = _mm512_inserti64x4(a, _mm512_castsi512_si256(b), 1);
  next = _mm512_shuffle_i64x2(a, b, 0xee);
}
HD_LANES Corners firstCorners(const short* bricks, const Lanes16& at) {
  Corners v;
  layerOf(bricks, at.i, v.v00, v.v10);
  v.v01 = v.v11 = v.v00;
  return v;
}
HD_LANES void otherCorners(const short* bricks, const Lanes16& at, Corners& v) {
  layerOf(bricks + 81, at.i, v.v01, v.v11);
}
HD_LANES F loadAreas(const unsigned short* p) {
  return _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))));
}
HD_LANES void storeAreas(unsigned short* p, F x) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm512_cvtepi32_epi16(_mm512_cvttps_epi32(x)));
}
HD_LANES __m128 halved(__m256 a) { return _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1)); }
HD_LANES float sumOf(F a) {
  __m128 x = halved(_mm256_add_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps(a, 1)));
  x = _mm_add_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_add_ss(x, _mm_shuffle_ps(x, x, 1)));
}
HD_LANES float leastOf(F a) {
  const __m256 y = _mm256_min_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps(a, 1));
  __m128 x = _mm_min_ps(_mm256_castps256_ps128(y), _mm256_extractf128_ps(y, 1));
  x = _mm_min_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_min_ss(x, _mm_shuffle_ps(x, x, 1)));
}

}  // namespace

#include "rt/contact/point_kernel_body.h"
#include "rt/contact/sphere_kernel_body.h"

namespace hapticd {
extern const PointKernel kAvx512PointKernel{run, reduce, bound, expire, settle, meet, reduceBalls, near, meetWindow};
}  // namespace hapticd
