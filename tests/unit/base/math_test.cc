#include "rt/base/math.h"

#include <gtest/gtest.h>

namespace hapticd {
namespace {

// In a function of its own, as code that uses it: this is what g++ 12 once got wrong.
[[gnu::noinline]] Vec3 rounded(const Vec3& x) {
  Vec3 y;
  for (int i = 0; i < 3; ++i) y[i] = asFloat(x[i]);
  return y;
}

TEST(Math, AFloatIsWhatAFloatHolds) {
  const Vec3 x(0.1, -0.2, 1e-3), y = rounded(x);
  for (int i = 0; i < 3; ++i) {
    volatile float stored = static_cast<float>(x[i]);
    EXPECT_EQ(y[i], stored);
    EXPECT_NE(y[i], x[i]);
  }
}

}  // namespace
}  // namespace hapticd
