// Effects where one rule ends and another begins: at the edge of their reach, on the surface, at their end, after a
// hand that was somewhere else.
#include <gtest/gtest.h>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

using test::effect;
using test::EffectScene;
using test::expectForce;

constexpr double kReach = 0.05, kHalfway = 0.045;  ///< Of the edge: there an effect is half of what it is.

TEST(EffectBorders, AllFadeOverTheEdgeOfTheirReach) {
  EffectScene buzz;
  buzz.add(effect(EffectKind::kVibration, 1, 0, 0, kReach));
  double most = 0;
  for (int i = 0; i < 60; ++i) most = std::max(most, buzz.feel({kHalfway, 0, 0}).norm());
  EXPECT_NEAR(most, 0.5, 1e-6);

  EffectScene guide;
  guide.add(effect(EffectKind::kGuide, 2, 200, 5, kReach));
  expectForce(guide.settled({kHalfway, 0, 0}, {0, 0.1, 0}), {-1, -0.25, 0});
}

TEST(EffectBorders, AFieldAboutAMeshIsALayerOnBothSides) {
  EffectScene t;
  test::TestMesh sphere = test::sphereMesh(0.03, 48);
  t.set(t.addMesh(sphere.view()), effect(EffectKind::kForce, 1, 0, 0, 0.005));
  for (const double r : {0.0255, 0.0345}) EXPECT_NEAR(t.settled({r, 0, 0}).z(), 0.5, 0.03) << r;
  expectForce(t.settled({0.01, 0, 0}), Vec3::Zero());
}

TEST(EffectBorders, AGuideToASurfaceDampsTowardItAndNotAlongIt) {
  EffectScene t;
  const auto ball = t.add(ShapeKind::kSphere, {0.02, 0, 0});
  t.set(ball, effect(EffectKind::kGuide, 2, 200, 5, kReach));
  expectForce(t.settled({0.025, 0, 0}, {0, 0.1, 0}), {-1, 0, 0});
  expectForce(t.settled({0.025, 0, 0}, {0.1, 0, 0}), {-1.5, 0, 0});
}

TEST(EffectBorders, AGuideDrawsFromWithinWhatDoesNotHoldTheHand) {
  for (const std::uint32_t flags : {std::uint32_t{0}, std::uint32_t{HD_OBJECT_TWO_SIDED | HD_OBJECT_ENABLED}}) {
    EffectScene t;
    const auto ball = t.add(ShapeKind::kSphere, {0.02, 0, 0});
    t.flags(ball, HD_OBJECT_ENABLED | HD_OBJECT_TWO_SIDED, flags);
    t.set(ball, effect(EffectKind::kGuide, 2, 200, 0, kReach));
    expectForce(t.settled({0.015, 0, 0}), {1, 0, 0});
  }
}

TEST(EffectBorders, AHandExactlyOnTheGuideIsLeftInPeace) {
  for (const ShapeKind kind : {ShapeKind::kGroup, ShapeKind::kPlane}) {
    EffectScene t;
    t.set(t.TestScene::add(kind, Vec3::Zero(), {}, {}, 0), effect(EffectKind::kGuide, 2, 200, 5, kReach));
    EXPECT_EQ(t.settled({0, 0, 0}, {0.1, 0.2, 0.3}), Vec3(Vec3::Zero()));
  }
}

TEST(EffectBorders, FrictionWithoutASpringOrAForceIsNothing) {
  for (const double force : {0.0, 1.0}) {
    EffectScene t;
    t.add(effect(EffectKind::kFriction, force, 0));
    for (int i = 0; i < 10; ++i) EXPECT_EQ(t.feel({1e-4 * i, 0, 0}), Vec3(Vec3::Zero())) << force;
  }
}

TEST(EffectBorders, AGuideIsGoneOneBlendAfterItsTime) {
  EffectScene t;
  EffectParameters bounded = effect(EffectKind::kGuide, 2, 200);
  bounded.until_ns = 50'000'000;
  t.add(bounded);
  Vec3 f = Vec3::Zero();
  while (t.now_ns < 50'000'000) f = t.feel({0.02, 0, 0});
  expectForce(f, {-2, 0, 0});
  while (t.now_ns < 60'000'000) f = t.feel({0.02, 0, 0});
  expectForce(f, {-1, 0, 0});
  while (t.now_ns < 71'000'000) f = t.feel({0.02, 0, 0});
  expectForce(f, Vec3::Zero());
}

TEST(EffectBorders, AHandThatWasSomewhereElseFeelsAllAtOnceAndNothingOfBefore) {
  EffectScene t;
  const auto id = t.add(effect(EffectKind::kForce, 1));
  t.add(effect(EffectKind::kFriction, 1, 1000));
  expectForce(t.settled({0, 0, 0}), {0, 0, 1});
  t.hand.reset();
  expectForce(t.feel({0.0005, 0, 0}), {0, 0, 1});  // Not held where it was.
  t.set(id, effect(EffectKind::kForce, 2));
  t.hand.reset();
  expectForce(t.feel({0.0005, 0, 0}), {0, 0, 2});
  t.set(id, effect(EffectKind::kForce, 3));
  (void)t.feel({0.0005, 0, 0});
  t.hand.reset();
  expectForce(t.feel({0.0005, 0, 0}), {0, 0, 3});
}

}  // namespace
}  // namespace hapticd
