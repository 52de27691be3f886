// The well of a guide: how it pulls, and that its depth is the work of that pull.
#include "rt/effect/well.h"

#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"

namespace hapticd {
namespace {

TEST(Well, IsASpringThatHoldsItsForceAndLetsGoAtItsReach) {
  const Well well(200, 1.5, 0.05);
  EXPECT_EQ(well.pull(0), 0);
  EXPECT_DOUBLE_EQ(well.pull(0.005), 1.0);
  EXPECT_DOUBLE_EQ(well.pull(0.0075), 1.5);
  EXPECT_DOUBLE_EQ(well.pull(0.039), 1.5);
  EXPECT_NEAR(well.pull(0.045), 0.75, 1e-12) << "half of the outer fifth";
  EXPECT_EQ(well.pull(0.05), 0);
  EXPECT_EQ(well.pull(1), 0);
}

TEST(Well, IsAsDeepAsTheWorkOfItsPullForAnyNumbers) {
  forSeeds(300, [](unsigned seed) {
    Random random(seed);
    const double stiffness = random.once(10) ? 0 : random.in(0, 2000), most = random.in(0, 5),
                 reach = random.in(0.001, 0.1);
    const Well well(stiffness, most, reach);
    constexpr int kSteps = 20'000;
    const double step = reach / kSteps, kink = stiffness * step * step / 8;  // What midpoints miss of its one bend.
    double work = 0, highest = 0;
    for (int i = kSteps - 1; i >= 0; --i) {  // From far away inward, midpoints.
      const double pull = well.pull((i + 0.5) / kSteps * reach);
      work += pull * reach / kSteps;
      highest = std::max(highest, pull);
      if (i % 500 == 0) {
        ASSERT_NEAR(well.depth(static_cast<double>(i) / kSteps * reach), work, 1e-6 * most * reach + kink);
      }
    }
    EXPECT_LE(highest, most * (1 + 1e-12));
    EXPECT_EQ(well.depth(reach), 0);
    EXPECT_EQ(well.depth(2 * reach), 0);
  });
}

}  // namespace
}  // namespace hapticd
