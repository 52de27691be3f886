/** @file
 * What haptic-bench sixdof calls good.
 */
#include "tools/haptic-bench/command/sixdof.h"

#include <gtest/gtest.h>

namespace haptic_bench {
namespace {

using hapticd::Vec3;

Judged judged(const Vec3& felt, const Vec3& truth) {
  Judged j;
  for (int i = 0; i < 10; ++i) j.add(felt, truth);
  return j;
}

TEST(SixDof, IsGoodWithinFivePerCentAndThreeDegrees) {
  EXPECT_TRUE(judged({1.04, 0, 0}, {1, 0, 0}).isGood(1));
  EXPECT_FALSE(judged({1.06, 0, 0}, {1, 0, 0}).isGood(100));
  EXPECT_FALSE(judged({0, 1, 0}, {1, 0, 0}).isGood(1));
  EXPECT_FALSE(judged({NAN, 0, 0}, {1, 0, 0}).isGood(1));
  EXPECT_DOUBLE_EQ(judged({0, 0, 0}, {3, 0, 4}).truth(), 5);
}

// Any finite torque was good where there should be none.
TEST(SixDof, ATorqueMadeOfNothingIsNotGood) {
  EXPECT_FALSE(judged({0, 1, 0}, Vec3::Zero()).isGood(1));
  EXPECT_FALSE(judged({0, NAN, 0}, Vec3::Zero()).isGood(1));
  EXPECT_TRUE(judged({0, 0.04, 0}, Vec3::Zero()).isGood(1));
  EXPECT_TRUE(judged(Vec3::Zero(), Vec3::Zero()).isGood(0));
}

}  // namespace
}  // namespace haptic_bench
