#include <cmath>
#include <cstring>

#include "rt/contact/point_kernel.h"

#define HD_LANES inline
#define HD_LANES_LAMBDA

namespace {

constexpr int kLanes = 16;

struct F {
  float x[kLanes];
};
struct I {
  std::int32_t x[kLanes];
};
using M = std::uint16_t;

template <class Out, class Make>
HD_LANES Out each(Make&& make) {
  Out out;
  for (int i = 0; i < kLanes; ++i) out.x[i] = make(i);
  return out;
}
template <class Test>
HD_LANES M bits(Test&& test) {
  unsigned mask = 0;
  for (int i = 0; i < kLanes; ++i) mask |= static_cast<unsigned>(test(i)) << i;
  return static_cast<M>(mask);
}
HD_LANES std::int32_t word(std::uint32_t x) { return static_cast<std::int32_t>(x); }
HD_LANES std::uint32_t bitsOf(std::int32_t x) { return static_cast<std::uint32_t>(x); }

HD_LANES F all(float x) {
  return each<F>([&](int) { return x; });
}
HD_LANES F zeroOf() { return all(0.0F); }
HD_LANES I allInt(std::int32_t x) {
  return each<I>([&](int) { return x; });
}
HD_LANES F load(const float* p) {
  return each<F>([&](int i) { return p[i]; });
}
HD_LANES void store(float* p, const F& a) { std::memcpy(p, a.x, sizeof a.x); }
HD_LANES F add(const F& a, const F& b) {
  return each<F>([&](int i) { return a.x[i] + b.x[i]; });
}
HD_LANES F sub(const F& a, const F& b) {
  return each<F>([&](int i) { return a.x[i] - b.x[i]; });
}
HD_LANES F mul(const F& a, const F& b) {
  return each<F>([&](int i) { return a.x[i] * b.x[i]; });
}
HD_LANES F quotient(const F& a, const F& b) {
  return each<F>([&](int i) { return a.x[i] / b.x[i]; });
}
// As the vector instructions: the second operand if they are equal or one is not a number.
HD_LANES F least(const F& a, const F& b) {
  return each<F>([&](int i) { return a.x[i] < b.x[i] ? a.x[i] : b.x[i]; });
}
HD_LANES F greatest(const F& a, const F& b) {
  return each<F>([&](int i) { return a.x[i] > b.x[i] ? a.x[i] : b.x[i]; });
}
HD_LANES F root(const F& a) {
  return each<F>([&](int i) { return std::sqrt(a.x[i]); });
}
HD_LANES M less(const F& a, const F& b) {
  return bits([&](int i) { return a.x[i] < b.x[i]; });
}
HD_LANES M lessEqual(const F& a, const F& b) {
  return bits([&](int i) { return a.x[i] <= b.x[i]; });
}
HD_LANES F choose(M m, const F& yes, const F& no) {
  return each<F>([&](int i) { return (m >> i & 1) != 0 ? yes.x[i] : no.x[i]; });
}
HD_LANES I toInt(const F& a) {
  return each<I>([&](int i) { return static_cast<std::int32_t>(a.x[i]); });
}
HD_LANES F toFloat(const I& a) {
  return each<F>([&](int i) { return static_cast<float>(a.x[i]); });
}
HD_LANES I addInt(const I& a, const I& b) {
  return each<I>([&](int i) { return word(bitsOf(a.x[i]) + bitsOf(b.x[i])); });
}
HD_LANES I subInt(const I& a, const I& b) {
  return each<I>([&](int i) { return word(bitsOf(a.x[i]) - bitsOf(b.x[i])); });
}
HD_LANES I mulInt(const I& a, const I& b) {
  return each<I>([&](int i) { return word(bitsOf(a.x[i]) * bitsOf(b.x[i])); });
}
HD_LANES I andInt(const I& a, const I& b) {
  return each<I>([&](int i) { return a.x[i] & b.x[i]; });
}
HD_LANES I orInt(const I& a, const I& b) {
  return each<I>([&](int i) { return a.x[i] | b.x[i]; });
}
HD_LANES I shiftRight3(const I& a) {
  return each<I>([&](int i) { return word(bitsOf(a.x[i]) >> 3); });
}
HD_LANES I shiftRight16(const I& a) {
  return each<I>([&](int i) { return a.x[i] >> 16; });
}
HD_LANES I shiftLeft16(const I& a) {
  return each<I>([&](int i) { return word(bitsOf(a.x[i]) << 16); });
}
HD_LANES I shiftedLeft(const I& a, int by) {
  return each<I>([&](int i) { return word(bitsOf(a.x[i]) << by); });
}
HD_LANES M hasBit(const std::uint32_t* words, const I& bit) {
  return bits([&](int i) { return (words[i % 4] & bitsOf(bit.x[i])) != 0; });
}
HD_LANES M equalInt(const I& a, const I& b) {
  return bits([&](int i) { return a.x[i] == b.x[i]; });
}
HD_LANES I masked(M m, const I& a) {
  return each<I>([&](int i) { return (m >> i & 1) != 0 ? a.x[i] : 0; });
}
HD_LANES I pairs(const I& values, const I& weights) {
  return each<I>([&](int i) {
    const auto low = [](std::int32_t w) { return static_cast<std::int32_t>(static_cast<std::int16_t>(w & 0xffff)); };
    return low(values.x[i]) * low(weights.x[i]) + (values.x[i] >> 16) * (weights.x[i] >> 16);
  });
}
HD_LANES I gather(const std::uint32_t* base, const I& index) {
  return each<I>([&](int i) { return word(base[index.x[i]]); });
}
HD_LANES I gatherPairs(const std::int16_t* base, const I& index) {
  return each<I>([&](int i) {
    std::int32_t pair;
    std::memcpy(&pair, base + index.x[i], sizeof pair);
    return pair;
  });
}
struct Lanes16 {
  alignas(64) std::int32_t i[16];
};
HD_LANES void keep(Lanes16& at, const I& x) { std::memcpy(at.i, x.x, sizeof at.i); }
HD_LANES I kept(const Lanes16& at) {
  return each<I>([&](int i) { return at.i[i]; });
}
struct Corners {
  I v00, v10, v01, v11;
};
HD_LANES I gatherKept(const std::uint32_t* base, const Lanes16& at) { return gather(base, kept(at)); }
HD_LANES Corners firstCorners(const std::int16_t* bricks, const Lanes16& at) {
  const I v00 = gatherPairs(bricks, kept(at));
  return {v00, v00, v00, v00};
}
HD_LANES void otherCorners(const std::int16_t* bricks, const Lanes16& at, Corners& v) {
  const I index = kept(at);
  v.v10 = gatherPairs(bricks + 9, index);
  v.v01 = gatherPairs(bricks + 81, index);
  v.v11 = gatherPairs(bricks + 90, index);
}
HD_LANES F loadAreas(const std::uint16_t* p) {
  return each<F>([&](int i) { return static_cast<float>(p[i]); });
}
HD_LANES void storeAreas(std::uint16_t* p, const F& a) {
  for (int i = 0; i < kLanes; ++i) p[i] = static_cast<std::uint16_t>(a.x[i]);
}
HD_LANES float sumOf(F a) {
  for (int half = kLanes / 2; half > 0; half /= 2) {
    for (int i = 0; i < half; ++i) a.x[i] += a.x[i + half];
  }
  return a.x[0];
}
HD_LANES float leastOf(const F& a) {
  float best = a.x[0];
  for (int i = 1; i < kLanes; ++i) best = a.x[i] < best ? a.x[i] : best;
  return best;
}

}  // namespace

#include "rt/contact/point_kernel_body.h"
#include "rt/contact/sphere_kernel_body.h"

namespace hapticd {
extern const PointKernel kPortablePointKernel{run, reduce, bound, expire, settle, meet, reduceBalls, near, meetWindow};
}  // namespace hapticd
