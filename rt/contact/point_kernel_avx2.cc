// Compiled with AVX2: nothing may be included here that has inline code of its own.
#include <immintrin.h>

#include "rt/contact/point_kernel.h"

#define HD_LANES __attribute__((always_inline)) inline
#define HD_LANES_LAMBDA __attribute__((always_inline))

namespace {

struct F {
  __m256 a, b;
};
struct I {
  __m256i a, b;
};
using M = unsigned short;

HD_LANES F all(float x) { return {_mm256_set1_ps(x), _mm256_set1_ps(x)}; }
HD_LANES F zeroOf() { return {_mm256_setzero_ps(), _mm256_setzero_ps()}; }
HD_LANES I allInt(int x) { return {_mm256_set1_epi32(x), _mm256_set1_epi32(x)}; }
HD_LANES F load(const float* p) { return {_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)}; }
HD_LANES void store(float* p, F x) {
  _mm256_storeu_ps(p, x.a);
  _mm256_storeu_ps(p + 8, x.b);
}
HD_LANES F add(F x, F y) { return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)}; }
HD_LANES F sub(F x, F y) { return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)}; }
HD_LANES F mul(F x, F y) { return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)}; }
HD_LANES F quotient(F x, F y) { return {_mm256_div_ps(x.a, y.a), _mm256_div_ps(x.b, y.b)}; }
HD_LANES F least(F x, F y) { return {_mm256_min_ps(x.a, y.a), _mm256_min_ps(x.b, y.b)}; }
HD_LANES F greatest(F x, F y) { return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)}; }
HD_LANES F root(F x) { return {_mm256_sqrt_ps(x.a), _mm256_sqrt_ps(x.b)}; }
HD_LANES M bitsOf(__m256 low, __m256 high) {
  return static_cast<M>(_mm256_movemask_ps(low) | _mm256_movemask_ps(high) << 8);
}
HD_LANES I lanesOfBits(M m) {
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i a = _mm256_and_si256(_mm256_set1_epi32(m), bit), b = _mm256_and_si256(_mm256_set1_epi32(m >> 8), bit);
  return {_mm256_cmpeq_epi32(a, bit), _mm256_cmpeq_epi32(b, bit)};
}
HD_LANES M less(F x, F y) { return bitsOf(_mm256_cmp_ps(x.a, y.a, _CMP_LT_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LT_OQ)); }
HD_LANES M lessEqual(F x, F y) {
  return bitsOf(_mm256_cmp_ps(x.a, y.a, _CMP_LE_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LE_OQ));
}
HD_LANES F choose(M m, F yes, F no) {
  const I l = lanesOfBits(m);
  return {_mm256_blendv_ps(no.a, yes.a, _mm256_castsi256_ps(l.a)),
          _mm256_blendv_ps(no.b, yes.b, _mm256_castsi256_ps(l.b))};
}
HD_LANES I toInt(F x) { return {_mm256_cvttps_epi32(x.a), _mm256_cvttps_epi32(x.b)}; }
HD_LANES F toFloat(I x) { return {_mm256_cvtepi32_ps(x.a), _mm256_cvtepi32_ps(x.b)}; }
HD_LANES I addInt(I x, I y) { return {_mm256_add_epi32(x.a, y.a), _mm256_add_epi32(x.b, y.b)}; }
HD_LANES I subInt(I x, I y) { return {_mm256_sub_epi32(x.a, y.a), _mm256_sub_epi32(x.b, y.b)}; }
HD_LANES I mulInt(I x, I y) { return {_mm256_mullo_epi32(x.a, y.a), _mm256_mullo_epi32(x.b, y.b)}; }
HD_LANES I andInt(I x, I y) { return {_mm256_and_si256(x.a, y.a), _mm256_and_si256(x.b, y.b)}; }
HD_LANES I orInt(I x, I y) { return {_mm256_or_si256(x.a, y.a), _mm256_or_si256(x.b, y.b)}; }
HD_LANES I shiftRight3(I x) { return {_mm256_srli_epi32(x.a, 3), _mm256_srli_epi32(x.b, 3)}; }
HD_LANES I shiftRight16(I x) { return {_mm256_srai_epi32(x.a, 16), _mm256_srai_epi32(x.b, 16)}; }
HD_LANES I shiftLeft16(I x) { return {_mm256_slli_epi32(x.a, 16), _mm256_slli_epi32(x.b, 16)}; }
HD_LANES I shiftedLeft(I x, int by) {
  const __m128i n = _mm_cvtsi32_si128(by);
  return {_mm256_sll_epi32(x.a, n), _mm256_sll_epi32(x.b, n)};
}
/** Four words, again and again: lanes that have a bit of theirs. */
HD_LANES M hasBit(const unsigned* words, I bit) {
  const __m256i four = _mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(words)));
  return bitsOf(_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(four, bit.a), bit.a)),
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(four, bit.b), bit.b)));
}
HD_LANES M equalInt(I x, I y) {
  return bitsOf(_mm256_castsi256_ps(_mm256_cmpeq_epi32(x.a, y.a)), _mm256_castsi256_ps(_mm256_cmpeq_epi32(x.b, y.b)));
}
HD_LANES I masked(M m, I x) { return andInt(lanesOfBits(m), x); }
HD_LANES I pairs(I values, I weights) {
  return {_mm256_madd_epi16(values.a, weights.a), _mm256_madd_epi16(values.b, weights.b)};
}
HD_LANES I gather(const unsigned* base, I index) {
  const int* p = reinterpret_cast<const int*>(base);
  return {_mm256_i32gather_epi32(p, index.a, 4), _mm256_i32gather_epi32(p, index.b, 4)};
}
HD_LANES I gatherPairs(const short* base, I index) {
  const int* p = reinterpret_cast<const int*>(base);
  return {_mm256_i32gather_epi32(p, index.a, 2), _mm256_i32gather_epi32(p, index.b, 2)};
}
struct Lanes16 {
  alignas(64) int i[16];
};
HD_LANES void keep(Lanes16& at, I x) {
  _mm256_store_si256(reinterpret_cast<__m256i*>(at.i), x.a);
  _mm256_store_si256(reinterpret_cast<__m256i*>(at.i + 8), x.b);
}
struct Corners {
  I v00, v10, v01, v11;
};
/** Words one by one, from indices in memory: a gather instruction takes half as long again (Zen 5). */
HD_LANES int wordAt(const unsigned* base, int i) { return static_cast<int>(base[i]); }
HD_LANES int wordAt(const short* base, int i) {
  int pair;
  __builtin_memcpy(&pair, base + i, sizeof pair);
  return pair;
}
template <class T>
HD_LANES __m128i four(const T* base, const int* at) {
  const __m128i x = _mm_insert_epi32(_mm_cvtsi32_si128(wordAt(base, at[0])), wordAt(base, at[1]), 1);
  return _mm_insert_epi32(_mm_insert_epi32(x, wordAt(base, at[2]), 2), wordAt(base, at[3]), 3);
}
template <class T>
HD_LANES I sixteen(const T* base, const Lanes16& at) {
  return {_mm256_inserti128_si256(_mm256_castsi128_si256(four(base, at.i)), four(base, at.i + 4), 1),
          _mm256_inserti128_si256(_mm256_castsi128_si256(four(base, at.i + 8)), four(base, at.i + 12), 1)};
}
HD_LANES I gatherKept(const unsigned* base, const Lanes16& at) { return sixteen(base, at); }
HD_LANES Corners firstCorners(const short* bricks, const Lanes16& at) {
  const I v00 = sixteen(bricks, at);
  return {v00, v00, v00, v00};
}
HD_LANES void otherCorners(const short* bricks, const Lanes16& at, Corners& v) {
  v.v10 = sixteen(bricks + 9, at);
  v.v01 = sixteen(bricks + 81, at);
  v.v11 = sixteen(bricks + 90, at);
}
HD_LANES F loadAreas(const unsigned short* p) {
  const __m256i x = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
  return {_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm256_castsi256_si128(x))),
          _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm256_extracti128_si256(x, 1)))};
}
HD_LANES void storeAreas(unsigned short* p, F x) {
  const __m256i words = _mm256_packus_epi32(_mm256_cvttps_epi32(x.a), _mm256_cvttps_epi32(x.b));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm256_permute4x64_epi64(words, 0xd8));
}
HD_LANES float sumOf(F v) {
  const __m256 y = _mm256_add_ps(v.a, v.b);
  __m128 x = _mm_add_ps(_mm256_castps256_ps128(y), _mm256_extractf128_ps(y, 1));
  x = _mm_add_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_add_ss(x, _mm_shuffle_ps(x, x, 1)));
}
HD_LANES float leastOf(F v) {
  const __m256 y = _mm256_min_ps(v.a, v.b);
  __m128 x = _mm_min_ps(_mm256_castps256_ps128(y), _mm256_extractf128_ps(y, 1));
  x = _mm_min_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_min_ss(x, _mm_shuffle_ps(x, x, 1)));
}

}  // namespace

#include "rt/contact/point_kernel_body.h"
#include "rt/contact/sphere_kernel_body.h"

namespace hapticd {
extern const PointKernel kAvx2PointKernel{run, reduce, bound, expire, settle, meet, reduceBalls, near, meetWindow};
}  // namespace hapticd
