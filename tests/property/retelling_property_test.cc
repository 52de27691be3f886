/** @file
 * The same scene in other words: its triangles in another order or cut in four, or all of it turned to anywhere. The
 * hand feels the same in every tick; scenes where it does not are counted. A few are left: where the hand balances,
 * rounding decides.
 */
#include <gtest/gtest.h>

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

/** Where friction lets go depends on the surface, not on what its flat sides are cut into. A slip over many faces ends
 * a little elsewhere where they are smaller. */
TEST(RetellingProperty, WhatAFlatSideIsCutIntoIsNotFeltForLong) {
  for (const bool ball : {false, true}) {
    SceneWish wish;
    wish.bodies = 1;
    wish.friction = true;
    wish.ball = ball;
    EXPECT_LE(differences(wish, cut).lasting, 10) << (ball ? "ball" : "point");
    wish.creeping = true;
    EXPECT_LE(differences(wish, cut).lasting, 3) << (ball ? "ball" : "point");
  }
}

}  // namespace
}  // namespace hapticd
