/** @file
 * The same scene in other words: its triangles in another order or cut in four, or all of it turned to anywhere. The
 * hand feels the same in every tick; scenes where it does not are counted. A few are left: where the hand balances,
 * rounding decides.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/for_seeds.h"
#include "tests/support/stepped/told_scene.h"

namespace hapticd {
namespace {

using test::RetoldScene;
using test::SceneTelling;
using test::SceneWish;
using test::ToldScene;

constexpr unsigned kRetold = 150;
constexpr int kRetoldTicks = 1200;
constexpr int kLasts = 20;  // Ticks: no longer a matter of which tick something happens in.

/** In how many scenes the forces differ, at any time or for long. */
struct Different {
  int ever = 0, lasting = 0;
};

/** `tell(seed)` says how they are told the second time. */
template <class Tell>
Different differences(const SceneWish& wish, Tell&& tell) {
  Different out;
  unsigned touched = 0;
  for (const unsigned seed : seeds(kRetold)) {
    const ToldScene scene(seed, wish, kRetoldTicks);
    RetoldScene one(scene, {}), other(scene, tell(seed));
    int run = 0, longest = 0, contacts = 0;
    for (int i = 0; i < kRetoldTicks; ++i) {
      const Vec3 force = one.next();
      const bool same = (other.next() - force).norm() < 1e-3 * (1 + force.norm());
      run = same ? 0 : run + 1;
      longest = std::max(longest, run);
      contacts += one.contact().object != 0;
    }
    touched += contacts > 100;
    out.ever += longest > 0;
    out.lasting += longest >= kLasts;
  }
  EXPECT_GT(touched, seeds(kRetold).size() / 2);
  return out;
}

SceneTelling shuffled(unsigned seed) {
  SceneTelling telling;
  telling.shuffle = seed;
  return telling;
}

SceneTelling turned(unsigned seed) {
  Random random(seed ^ 0x5eedu);
  SceneTelling telling;
  telling.at = random.pose(0.05);
  return telling;
}

SceneTelling cut(unsigned) {
  SceneTelling telling;
  telling.in_four = true;
  return telling;
}

/** In a groove of two meshes it is the deeper one whose faces are followed, not that which was met first. */
TEST(RetellingProperty, WhichOfTwoMeshesIsMetFirstIsNotFelt) {
  for (const bool ball : {false, true}) {
    SceneWish wish;
    wish.bodies = 2;
    wish.ball = ball;
    EXPECT_EQ(differences(wish, shuffled).ever, 0) << (ball ? "ball" : "point");
    EXPECT_LE(differences(wish, turned).ever, 2) << (ball ? "ball" : "point");
  }
}

/** Where friction lets go, and where the slip ends, depends on the surface, not on what its flat sides are cut into. */
TEST(RetellingProperty, WhatAFlatSideIsCutIntoIsNotFelt) {
  for (const bool ball : {false, true}) {
    SceneWish wish;
    wish.bodies = 1;
    wish.friction = true;
    wish.ball = ball;
    const Different fast = differences(wish, cut);
    EXPECT_LE(fast.ever, 6) << (ball ? "ball" : "point");
    EXPECT_LE(fast.lasting, 2) << (ball ? "ball" : "point");
    wish.creeping = true;
    EXPECT_LE(differences(wish, cut).ever, 3) << (ball ? "ball" : "point");
  }
}

/** Nor over which ridge of a flat side a hand without friction goes, however many triangles lie between. */
TEST(RetellingProperty, WhatAFlatSideIsCutIntoIsNotFeltWithoutFriction) {
  for (const bool ball : {false, true}) {
    SceneWish wish;
    wish.bodies = 1;
    wish.ball = ball;
    EXPECT_LE(differences(wish, cut).ever, 3) << (ball ? "ball" : "point");
  }
}

/**
 * Who sticks in a hollow of one mesh is as deep as both its sides tell, whichever of their faces a sweep has met: also
 * while something else moves that reaches about the hand, and all is looked at afresh.
 */
TEST(RetellingProperty, WhoSticksInAHollowIsAsDeepAsBothSidesTell) {
  forSeeds(60, [](unsigned seed) {
    Random random(seed);
    constexpr double kHalf = 0x1p-4;
    const double radius = random.once(2) ? 0 : random.in(1e-4, 2e-3);
    const double slope = std::round(random.in(0.7, 1.5) * kHalf / test::kVertexStep) * test::kVertexStep / kHalf;
    test::TestMesh valley = test::heightMesh(kHalf, 2, [&](double x, double) { return slope * std::abs(x); });
    for (int cuts = static_cast<int>(random.below(3)); cuts > 0; --cuts) valley = test::inFour(valley);
    const Pose at = random.pose(0.1);
    test::TestScene t(radius);
    t.addMesh(valley.view(), at, {1000, 2, 0.5, 0.4});
    const Vec3 above(0, 0, 0.05);
    const std::uint32_t beam = t.add(ShapeKind::kBox, {0.1, 0.002, 0.002}, at * Pose{above, Quat::Identity()});
    const Vec3 bottom(0, random.in(-0.02, 0.02), radius * std::sqrt(1 + slope * slope));
    for (int i = 0; i < 240; ++i) t.tick(at * (bottom + Vec3(0, 0, 0.02 - 1e-4 * i)));
    for (int i = 0; i < 300; ++i) {
      // Past straight down by more than the sides lean, one of them alone presses.
      const double deep = random.in(0.004, 0.005), lean = std::atan(slope), turn = random.in(-1, 1) * (lean + 0.3);
      const Vec3 hip(deep * std::sin(turn), random.in(-0.3, 0.3) * deep, -deep * std::cos(turn));
      if (random.once(2)) t.pose(beam, at * Pose{above + Vec3(0, 0, 1e-5 * i), Quat::Identity()});
      t.tick(at * (bottom + hip));
      ASSERT_LT((at.inverse() * t.contact.proxy - bottom).norm(), 1e-9) << "tick " << i;
      ASSERT_NEAR(t.contact.depth, deep * std::cos(std::max(0.0, std::abs(turn) - lean)), 1e-9) << "tick " << i;
    }
  });
}

}  // namespace
}  // namespace hapticd
