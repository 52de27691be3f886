// How much is felt of a world whose point is held by a clutch.
#include "rt/cycle/clutch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

constexpr double kTick_s = 1e-3;

/** Held from the first tick on, until nothing is felt. */
Clutch takenOff() {
  Clutch clutch;
  clutch.set({0, 1, 0, 0, {}});
  clutch.begin(0, kTick_s);
  clutch.freeze({1, 2, 3});
  return clutch;
}

TEST(Clutch, FallsSteadilyWhereSomethingIsFeltAndElseAtOnce) {
  Clutch clutch;
  clutch.set({0, 1, 0, 0, {}});
  clutch.end(true, 0);
  for (int i = 1; i <= 60; ++i) {
    clutch.begin(0, kTick_s);
    EXPECT_NEAR(clutch.weight(), std::max(0.0, 1 - i * kTick_s / Clutch::kFall_s), 1e-12);
    EXPECT_EQ(clutch.rose(), 0);
  }
  EXPECT_EQ(takenOff().weight(), 0);
}

TEST(Clutch, RisesWhenThePointFollowsTheHandAgain) {
  Clutch clutch = takenOff();
  clutch.set({0, 0, 0, 0, {}});
  clutch.begin(0, kTick_s);
  EXPECT_EQ(clutch.weight(), 0) << "it still stands";
  clutch.thaw();
  for (int i = 1; i <= 120; ++i) {
    clutch.begin(0, kTick_s);
    EXPECT_NEAR(clutch.weight(), std::min(1.0, i * kTick_s / Clutch::kRise_s), 1e-12);
  }
}

/** Whatever springs hold meanwhile, and however late a tick comes. */
TEST(Clutch, BringsNoMoreThanItsPowerAndSaysWhat) {
  Clutch clutch = takenOff();
  clutch.set({0, 0, 0, 0, {}});
  clutch.thaw();
  double before = 0;
  for (int i = 0; i < 3000; ++i) {
    const double stored = i % 3 == 0 ? 0.0 : 1e-3 * (i % 7), passed = kTick_s * (1 + i % 4);
    clutch.end(true, stored);
    clutch.begin(0, passed);
    // Both bounds hold, and one of them is reached until all is felt.
    const double power = clutch.rose() * stored / (Clutch::kMostPower * passed);
    const double speed = clutch.rose() * Clutch::kRise_s / passed;
    ASSERT_LE(std::max(power, speed), 1 + 1e-12) << i;
    ASSERT_GE(std::max({power, speed, clutch.weight()}), 1 - 1e-12) << i;
    ASSERT_NEAR(clutch.weight() - before, clutch.rose(), 1e-15) << i;
    before = clutch.weight();
  }
  EXPECT_EQ(before, 1);
}

TEST(Clutch, EachOfThirtyTwoButtonsHoldsIt) {
  for (std::uint32_t button = 0; button <= 34; ++button) {
    const SetClutch order{0, 0, button, 0, {}};
    ASSERT_EQ(Clutch::valid(order), button <= 32) << button;
    if (!Clutch::valid(order)) continue;
    Clutch clutch;
    clutch.set(order);
    const std::uint32_t its = button == 0 ? 0u : 1u << (button - 1);
    EXPECT_EQ(clutch.held(its), button != 0) << button;
    EXPECT_EQ(clutch.held(0xffffffffu), button != 0) << button;
    EXPECT_FALSE(clutch.held(~its)) << button;
  }
  EXPECT_FALSE(Clutch::valid({0, 0, 0, 1, {0, NAN, 0}}));
}

TEST(Clutch, ANewOneTakesItOverWhereItStands) {
  const Clutch clutch = takenOff();
  const SetClutch order = clutch.order(2);
  EXPECT_EQ(order.device, 2u);
  EXPECT_EQ(order.held, 1u);
  EXPECT_EQ(order.frozen, 1u);
  Clutch other;
  other.set(order);
  EXPECT_TRUE(other.frozen());
  EXPECT_EQ(other.anchor(), Vec3(1, 2, 3));
  EXPECT_EQ(other.weight(), 0);
  EXPECT_EQ(Clutch().order(1).frozen, 0u);
}

}  // namespace
}  // namespace hapticd
