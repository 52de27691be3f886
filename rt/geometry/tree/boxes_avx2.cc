// Compiled with AVX2: nothing may be included here that has inline code of its own.
#include <immintrin.h>

#include "rt/geometry/tree/boxes.h"

namespace hapticd {
namespace {

/** Of eight boxes the square of what lies between them and a range, along one axis. */
__m256 squaredOutside(const float* lower, const float* upper, __m256 from, __m256 to) noexcept {
  const __m256 below = _mm256_sub_ps(_mm256_loadu_ps(lower), to), above = _mm256_sub_ps(from, _mm256_loadu_ps(upper));
  const __m256 outside = _mm256_max_ps(_mm256_max_ps(below, above), _mm256_setzero_ps());
  return _mm256_mul_ps(outside, outside);
}

std::uint32_t enter(const hd_bvh_node& node, const BoxSweep& sweep, float t_max, float* key) noexcept {
  __m256 in = _mm256_setzero_ps(), out = _mm256_set1_ps(t_max);
  for (int axis = 0; axis < 3; ++axis) {
    const float* const entry = sweep.upward[axis] != 0 ? node.lower[axis] : node.upper[axis];
    const float* const exit = sweep.upward[axis] != 0 ? node.upper[axis] : node.lower[axis];
    const __m256 inverse = _mm256_set1_ps(sweep.inverse[axis]);
    const __m256 t_entry =
        _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(entry), _mm256_set1_ps(sweep.entry[axis])), inverse);
    const __m256 t_exit =
        _mm256_mul_ps(_mm256_sub_ps(_mm256_loadu_ps(exit), _mm256_set1_ps(sweep.exit[axis])), inverse);
    in = _mm256_max_ps(t_entry, in);
    out = _mm256_min_ps(t_exit, out);
  }
  _mm256_storeu_ps(key, in);
  const __m256 wider = _mm256_mul_ps(out, _mm256_set1_ps(1 + 0x1p-20F));
  const auto mask = static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(in, wider, _CMP_LE_OQ)));
  return mask & ((1u << node.used) - 1);
}

std::uint32_t approach(const hd_bvh_node& node, const BoxPoint& point, float squared_reach, float* key) noexcept {
  __m256 sum = _mm256_setzero_ps();
  for (int axis = 0; axis < 3; ++axis) {
    const __m256 from = _mm256_set1_ps(point.lower[axis]), to = _mm256_set1_ps(point.upper[axis]);
    sum = _mm256_add_ps(sum, squaredOutside(node.lower[axis], node.upper[axis], from, to));
  }
  _mm256_storeu_ps(key, sum);
  const auto mask =
      static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(sum, _mm256_set1_ps(squared_reach), _CMP_LE_OQ)));
  return mask & ((1u << node.used) - 1);
}

std::uint64_t near(const PrismBoxes* boxes, std::uint32_t blocks, const PrismSweep& sweep) noexcept {
  __m256 from[3], to[3];
  for (int axis = 0; axis < 3; ++axis) {
    const __m256 a = _mm256_set1_ps(sweep.a[axis]), b = _mm256_set1_ps(sweep.b[axis]);
    from[axis] = _mm256_min_ps(a, b);
    to[axis] = _mm256_max_ps(a, b);
  }
  const __m256 reach = _mm256_set1_ps(sweep.radius_squared);
  std::uint64_t bits = 0;
  for (std::uint32_t k = 0; k < blocks; k += kPrismWidth, ++boxes) {
    __m256 squared = _mm256_setzero_ps();
    for (int axis = 0; axis < 3; ++axis) {
      const __m256 outside = squaredOutside(boxes->lower[axis], boxes->upper[axis], from[axis], to[axis]);
      squared = _mm256_add_ps(squared, outside);
    }
    const auto met = static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(squared, reach, _CMP_LE_OQ)));
    bits |= static_cast<std::uint64_t>(met) << k;
  }
  return blocks < kPrismBlocks ? bits & ((std::uint64_t{1} << blocks) - 1) : bits;
}

}  // namespace

extern const BoxTests kAvx2BoxTests{enter, approach, near, reachPrismsAvx2, makePrismsAvx2};

}  // namespace hapticd
