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
HD_LANES M equalInt(I a, I b) { return _mm512_cmpeq_epi32_mask(a, b); }
HD_LANES I masked(M m, I a) { return _mm512_maskz_mov_epi32(m, a); }
HD_LANES I pairs(I values, I weights) { return _mm512_madd_epi16(values, weights); }
HD_LANES I gather(const unsigned* base, I index) { return _mm512_i32gather_epi32(index, base, 4); }
HD_LANES I gatherPairs(const short* base, I index) { return _mm512_i32gather_epi32(index, base, 2); }
HD_LANES F loadAreas(const unsigned short* p) {
  return _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))));
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

namespace hapticd {
extern const PointKernel kAvx512PointKernel{run, reduce, bound, expire};
}  // namespace hapticd
