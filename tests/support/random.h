/** @file
 * Seeded randomness for tests: the same numbers for the same seed with every compiler and library, which the
 * distributions of the standard do not promise. With a taste for trouble.
 */
#pragma once

#include <cstdint>
#include <limits>
#include <random>

#include "rt/base/math.h"
#include "tests/support/seeds.h"

namespace hapticd {

/** Neither allocates nor throws, so a forked child may have one. */
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}

  double in(double low, double high) { return low + (high - low) * (engine_() * 0x1p-32); }
  bool once(double in_so_many) { return in(0, in_so_many) < 1; }
  /** 0 to n - 1. */
  template <class Int>
  Int below(Int n) {
    return static_cast<Int>(in(0, n));
  }
  std::uint64_t bits() {
    const std::uint64_t high = engine_();
    return high << 32 | engine_();
  }
  /** In a cube around zero, twice `size` wide. */
  Vec3 vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  /** By up to 3 rad. */
  Quat turn() {
    const Vec3 axis = vector(1).normalized();  // First: in which order arguments are made differs between compilers.
    return Quat(Eigen::AngleAxisd(in(0, 3), axis));
  }
  Pose pose(double size) {
    const Vec3 p = vector(size);
    return {p, turn()};
  }

  /** Not finite. */
  double broken() {
    const double kinds[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::signaling_NaN()};
    return kinds[below(4)];
  }
  /** Finite, of any size from denormal to the largest there is. */
  double wild() {
    const double sign = once(2) ? -1 : 1;
    switch (below(5)) {
      case 0:
        return sign * std::numeric_limits<double>::denorm_min() * below(1000);
      case 1:
        return sign * std::numeric_limits<double>::max();
      case 2:
        return sign * std::pow(10, in(-320, 308));
      case 3:
        return sign * 0.0;
      default:
        return sign * in(0, 20);
    }
  }
  Vec3 wildVector() { return {wild(), wild(), wild()}; }

 private:
  std::mt19937 engine_;
};

}  // namespace hapticd
