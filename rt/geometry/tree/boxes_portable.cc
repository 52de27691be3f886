#include "rt/geometry/tree/boxes.h"

namespace hapticd {
namespace {

constexpr int kWidth = HD_BVH_WIDTH;
constexpr float kWider = 1 + 0x1p-20F;

// As the vector instructions: the second operand if they are equal or one is not a number.
float least(float a, float b) noexcept { return a < b ? a : b; }
float greatest(float a, float b) noexcept { return a > b ? a : b; }

/** The square of what lies between a box and a range, along one axis. */
float squaredOutside(float lower, float upper, float from, float to) noexcept {
  const float outside = greatest(greatest(lower - to, from - upper), 0.0F);
  return outside * outside;
}

std::uint32_t enter(const hd_bvh_node& node, const BoxSweep& sweep, float t_max, float* key) noexcept {
  float out[kWidth];
  for (int i = 0; i < kWidth; ++i) {
    key[i] = 0;
    out[i] = t_max;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const float* const entry = sweep.upward[axis] != 0 ? node.lower[axis] : node.upper[axis];
    const float* const exit = sweep.upward[axis] != 0 ? node.upper[axis] : node.lower[axis];
    for (int i = 0; i < kWidth; ++i) {
      key[i] = greatest((entry[i] - sweep.entry[axis]) * sweep.inverse[axis], key[i]);
      out[i] = least((exit[i] - sweep.exit[axis]) * sweep.inverse[axis], out[i]);
    }
  }
  std::uint32_t mask = 0;
  for (int i = 0; i < kWidth; ++i) mask |= static_cast<std::uint32_t>(key[i] <= out[i] * kWider) << i;
  return mask & ((1u << node.used) - 1);
}

std::uint32_t approach(const hd_bvh_node& node, const BoxPoint& point, float squared_reach, float* key) noexcept {
  for (int i = 0; i < kWidth; ++i) key[i] = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kWidth; ++i) {
      key[i] = key[i] + squaredOutside(node.lower[axis][i], node.upper[axis][i], point.lower[axis], point.upper[axis]);
    }
  }
  std::uint32_t mask = 0;
  for (int i = 0; i < kWidth; ++i) mask |= static_cast<std::uint32_t>(key[i] <= squared_reach) << i;
  return mask & ((1u << node.used) - 1);
}

std::uint64_t near(const PrismBoxes* boxes, std::uint32_t blocks, const PrismSweep& sweep) noexcept {
  std::uint64_t bits = 0;
  for (std::uint32_t k = 0; k < blocks; ++k) {
    const PrismBoxes& box = boxes[k / kPrismWidth];
    const std::uint32_t i = k % kPrismWidth;
    float squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float from = least(sweep.a[axis], sweep.b[axis]), to = greatest(sweep.a[axis], sweep.b[axis]);
      squared = squared + squaredOutside(box.lower[axis][i], box.upper[axis][i], from, to);
    }
    bits |= static_cast<std::uint64_t>(squared <= sweep.radius_squared) << k;
  }
  return bits;
}

}  // namespace

extern const BoxTests kPortableBoxTests{enter, approach, near, reachPrismsPortable, makePrismsPortable};

}  // namespace hapticd
