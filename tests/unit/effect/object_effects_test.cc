// What each effect does to a hand, by its law.
#include "rt/effect/object_effects.h"

#include <gtest/gtest.h>

#include "rt/effect/drags.h"
#include "rt/geometry/nearest/nearest.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

using test::effect;
using test::EffectScene;
using test::expectForce;

TEST(ObjectEffects, AForceActsAlongTheObjectsAxisWithinItsReach) {
  EffectScene t;
  const Quat turned(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));  // z becomes -y.
  const auto id = t.add(effect(EffectKind::kForce, 1.5), {{0.1, 0, 0}, turned});
  expectForce(t.settled({0.1, 0, 0}), {0, -1.5, 0});
  expectForce(t.settled({0.1, 0, 0.039}), {0, -1.5, 0});
  expectForce(t.settled({0.1, 0, 0.045}), {0, -0.75, 0});
  expectForce(t.settled({0.1, 0, 0.051}), Vec3::Zero());
  t.pose(id, {{0.1, 0, 0}, Quat::Identity()});
  expectForce(t.settled({0.1, 0, 0}), {0, 0, 1.5});
}

/** Fields too may lie along a path: beyond its reach there is none of it. */
TEST(ObjectEffects, OfAPathNothingIsFeltBeyondItsReach) {
  for (const EffectKind kind : {EffectKind::kForce, EffectKind::kViscous, EffectKind::kFriction}) {
    EffectScene t;
    t.add(test::along(effect(kind, 1.5, 100, 10, 0.02), {{-0.1, 0, 0}, {0.1, 0, 0}}));
    Vec3 near = Vec3::Zero(), far = Vec3::Zero();
    for (int i = 0; i < 100; ++i) near += t.feel({1e-3 * i - 0.05, 0.005, 0}, {1, 0, 0});
    EXPECT_GT(near.norm(), 10) << static_cast<int>(kind);
    (void)t.settled({0, 0.021, 0});
    for (int i = 0; i < 100; ++i) far += t.feel({1e-3 * i - 0.05, 0.021, 0}, {1, 0, 0});
    EXPECT_EQ(far, Vec3(0, 0, 0)) << static_cast<int>(kind);
  }
}

TEST(ObjectEffects, AViscousBoxDampsWhatMovesInItRelativeToIt) {
  EffectScene t;
  const auto bath = t.add(ShapeKind::kBox, {0.1, 0.1, 0.1});
  t.set(bath, effect(EffectKind::kViscous, 3, 0, 4, 0.01));
  expectForce(t.settled({0.02, 0.03, 0}, {0.1, -0.2, 0}), {-0.4, 0.8, 0});
  expectForce(t.settled({0, 0, 0}, {2, 0, 0}), {-3, 0, 0});
  expectForce(t.settled({0.111, 0, 0}, {0.1, 0, 0}), Vec3::Zero());
  expectForce(t.settled({0.109, 0, 0}, {0.1, 0, 0}), {-0.2, 0, 0});
  t.pose(bath, {}, {{0.1, 0, 0}, Vec3::Zero()});
  expectForce(t.settled({0, 0, 0}, {0.1, 0, 0}), Vec3::Zero());
}

/** Of 60 and 20 N s/m at one place a device that shows 40 feels 30 and 10, each no more than its force. */
TEST(ObjectEffects, DragsTogetherDampByWhatTheDeviceCanShow) {
  EffectScene t;
  t.add(effect(EffectKind::kViscous, 3, 0, 60, 1));
  t.hand.setMaxDamping(40);
  expectForce(t.settled({0, 0, 0}, {0.01, 0, 0}), {-0.4, 0, 0});
  expectForce(t.settled({0, 0, 0}, {0.1, 0, 0}), {-3, 0, 0});  // All of its force, a little faster.
  t.add(test::along(effect(EffectKind::kGuide, 2, 100, 20, 1), {{-1, 0, 0}, {1, 0, 0}}));
  const Vec3 off(0, 0.015, 0);  // Of the guide: it draws back with 1.5 N.
  expectForce(t.settled(off, {0.01, 0, 0}), {-0.3, -1.5, 0});
  expectForce(t.settled(off, {0, 0, 0.01}), {0, -1.5, -0.4});
  expectForce(t.settled(off, {0, 0, 0.2}), {0, -1.5, -3 - 1.5});
  t.hand.setMaxDamping(100);
  expectForce(t.settled(off, {0.01, 0, 0}), {-0.6, -1.5, 0});
}

/** However thick one is that has no force for it, the others act as without it; and so little of it as it shows counts.
 */
TEST(ObjectEffects, ADragWithoutForceTakesNothingFromTheOthers) {
  for (const double weak : {0.0, 1e-6}) {
    EffectScene t;
    t.add(effect(EffectKind::kViscous, 3, 0, 30, 1));
    t.add(effect(EffectKind::kViscous, weak, 0, 1000, 1));
    t.hand.setMaxDamping(40);
    expectForce(t.settled({0, 0, 0}, {0.01, 0, 0}), {-0.3, 0, 0}, 2e-6);
    EXPECT_NEAR(t.hand.damping(), 30, 2e-4);
    expectForce(t.settled({0, 0, 0}, {0.2, 0, 0}), {-3, 0, 0}, 2e-6);
    EXPECT_NEAR(t.hand.damping(), 15, 2e-5);
  }
}

// Not at rest either, where it would be strong enough for its damping.
TEST(ObjectEffects, ADragWithoutForceTakesNothingFromABeltThatMovesAHandAtRest) {
  Drags drags;
  drags.add(Vec3::Zero(), 1000, 0);
  drags.add({-0.1, 0, 0}, 5, 2);
  expectForce(drags.force(2), {0.2, 0, 0});
}

TEST(ObjectEffects, FrictionHoldsAndIsThenDraggedAlong) {
  EffectScene t;
  t.add(effect(EffectKind::kFriction, 2, 2000));
  expectForce(t.settled({0, 0, 0}), Vec3::Zero());
  expectForce(t.feel({0.0005, 0, 0}), {-1, 0, 0});
  expectForce(t.feel({0, 0, 0}), Vec3::Zero());
  for (int i = 0; i <= 100; ++i) (void)t.feel({1e-4 * i, 0, 0});
  expectForce(t.feel({0.01, 0, 0}), {-2, 0, 0});
  expectForce(t.feel({0.0095, 0, 0}), {-1, 0, 0});
  expectForce(t.feel({0.009, 0, 0}), Vec3::Zero());
  expectForce(t.feel({0.008, 0, 0}), {2, 0, 0});
  for (int i = 80; i <= 450; ++i) (void)t.feel({1e-4 * i, 0, 0});
  expectForce(t.feel({0.045, 0, 0}), {-1, 0, 0});  // Half of the way through the outer fifth.
}

TEST(ObjectEffects, FrictionThatLetGoHoldsAnew) {
  EffectScene t;
  const auto id = t.add(effect(EffectKind::kFriction, 1, 1000));
  (void)t.settled({0, 0, 0});
  (void)t.settled({1, 0, 0});
  expectForce(t.settled({0.002, 0, 0}), Vec3::Zero());
  t.set(id, effect(EffectKind::kForce, 0));
  (void)t.settled({0.002, 0, 0});
  (void)t.settled({0.005, 0, 0});
  t.set(id, effect(EffectKind::kFriction, 1, 1000));
  expectForce(t.settled({0.005, 0, 0}), Vec3::Zero());
}

TEST(ObjectEffects, AVibrationSwingsAtItsFrequency) {
  EffectScene t;
  t.add(effect(EffectKind::kVibration, 0.5));
  (void)t.settled({0, 0, 0});
  double sine = 0, cosine = 0, all = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 f = t.feel({0, 0, 0});
    ASSERT_EQ(f.x(), 0);
    ASSERT_LE(std::abs(f.z()), 0.5 + 1e-12);
    sine += f.z() * std::sin(2 * M_PI * 50e-3 * i);
    cosine += f.z() * std::cos(2 * M_PI * 50e-3 * i);
    all += f.z() * f.z();
  }
  EXPECT_NEAR(std::hypot(sine, cosine) / 500, 0.5, 1e-6);
  EXPECT_NEAR(all / 1000, 0.125, 1e-6) << "nothing at other frequencies";
}

/** In phase with the clock, also a month after its zero. */
TEST(ObjectEffects, AVibrationSwingsWithTheClock) {
  EffectScene t;
  EffectParameters buzz = effect(EffectKind::kVibration, 0.5);
  buzz.frequency = 62.5;
  t.add(buzz);
  (void)t.settled({0, 0, 0});
  for (const std::int64_t since : {std::int64_t{0}, std::int64_t{31} * 86400 * 1'000'000'000}) {
    for (int i = 0; i < 40; ++i) {
      t.now_ns = since + i * std::int64_t{1'000'000};
      const std::int64_t now_ns = t.now_ns + 1'000'000;
      const double turns = static_cast<double>(now_ns % 16'000'000) / 16e6;
      expectForce(t.feel({0, 0, 0}), {0, 0, 0.5 * std::sin(2 * M_PI * turns)});
    }
  }
}

TEST(ObjectEffects, AGuideDrawsToAPointOrALineOrASurface) {
  EffectScene t;
  const auto id = t.add(effect(EffectKind::kGuide, 2, 200), {{0, 0, 0.1}, Quat::Identity()});
  expectForce(t.settled({0.003, 0, 0.1}), {-0.6, 0, 0});
  expectForce(t.settled({0, 0.03, 0.1}), {0, -2, 0});
  t.set(id, test::along(effect(EffectKind::kGuide, 2, 200), {{-0.1, 0, 0}, {0.1, 0, 0}}));
  expectForce(t.settled({0.07, 0.004, 0.1}), {0, -0.8, 0});
  expectForce(t.settled({0.11, 0, 0.1}), {-2, 0, 0});

  EffectScene magnet;
  const auto ball = magnet.add(ShapeKind::kSphere, {0.02, 0, 0});
  magnet.set(ball, effect(EffectKind::kGuide, 2, 200));
  expectForce(magnet.settled({0.025, 0, 0}), {-1, 0, 0});
  expectForce(magnet.settled({0.015, 0, 0}), Vec3::Zero());
  magnet.flags(ball, HD_OBJECT_ENABLED, 0);
  expectForce(magnet.settled({0.015, 0, 0}), {1, 0, 0});
}

TEST(ObjectEffects, AGuideDrawsToAMesh) {
  EffectScene t;
  test::TestMesh sphere = test::sphereMesh(0.03, 24);
  const auto id = t.addMesh(sphere.view());
  t.set(id, effect(EffectKind::kGuide, 2, 200));
  const Vec3 f = t.settled({0.036, 0, 0});
  EXPECT_NEAR(f.norm(), 1.2, 0.1);
  EXPECT_LT(f.x(), -1.1);
  expectForce(t.settled({0.02, 0, 0}), Vec3::Zero());
}

/** Else another guide would draw at once where the hand is pressed in deeper than the reach. */
TEST(ObjectEffects, AGuideToAMeshIsAsNearAtAnyDepthWithinAsThatToABox) {
  EffectScene box, mesh;
  test::TestMesh block = test::boxMesh({0.03, 0.04, 0.05});
  const auto as_box = box.add(ShapeKind::kBox, {0.03, 0.04, 0.05}), as_mesh = mesh.addMesh(block.view());
  for (auto& [t, id] : {std::pair<EffectScene&, std::uint32_t>(box, as_box), {mesh, as_mesh}}) {
    t.set(id, effect(EffectKind::kGuide, 20, 4000, 0, 0.005));
    t.add(effect(EffectKind::kGuide, 0.05, 100, 0, 0.2), {{0.005, 0.006, 0.007}, Quat::Identity()});
    (void)t.settled({0, 0, 0.2});
  }
  int away = 0;
  for (int i = 0; i < 140; ++i) {
    const Vec3 x(0.004 - 1e-4 * i, 0.001, 0.07 - 1e-3 * i);
    const Vec3 wanted = box.feel(x);
    expectForce(mesh.feel(x), wanted, 1e-5);
    away += wanted.norm() > 0 ? 1 : 0;
  }
  EXPECT_GT(away, 20) << "else the test shows nothing";
  EXPECT_LT(away, 60);
}

/** Beside its border nothing would hold the hand that is behind its plane, and a way around it would give energy. */
TEST(ObjectEffects, AGuideDrawsToASheetFromBothSides) {
  EffectScene t;
  test::TestMesh sheet = test::heightMesh(0.02, 4, [](double, double) { return 0.0; });
  const auto id = t.addMesh(sheet.view());
  t.set(id, effect(EffectKind::kGuide, 1, 200));
  for (const double z : {1e-6, -1e-6}) EXPECT_NEAR(t.settled({0.03, 0, z}).x(), -1, 1e-3) << z;
}

/** Where nothing is near enough for the tree to leave much out: in the middle of a ball. */
TEST(ObjectEffects, AGuideDrawsToAMeshTooLargeToSearchWhole) {
  EffectScene t;
  constexpr double kSize = 0.03;
  test::TestMesh sphere = test::sphereMesh(kSize, 24);
  const auto id = t.addMesh(sphere.view());
  t.flags(id, HD_OBJECT_ENABLED, 0);
  t.set(id, effect(EffectKind::kGuide, 2, 50));
  (void)t.settled({0, 0.001, 0});
  int searched_in_vain = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 x(0.001 * std::sin(0.1 * i), 0.001 * std::cos(0.1 * i), 0.0005 * std::sin(0.07 * i));
    NearestQuery query;
    query.x = x;
    query.limit = ObjectEffects::kMostVisits;
    Nearest nearest;
    if (nearestOnShape(t.scene->find(id)->shape, query, nearest) == NearestResult::kExhausted) ++searched_in_vain;
    EXPECT_NEAR(t.feel(x).norm(), 50 * (kSize - x.norm()), 50 * 2 * x.norm()) << i;
  }
  EXPECT_GT(searched_in_vain, 100);
}

/** However many there are: those that come late have less to search with, and draw all the same. */
TEST(ObjectEffects, GuidesToManyMeshesShareTheirWork) {
  test::TestMesh sphere = test::sphereMesh(0.03, 24);
  MeshView* const mesh = sphere.view();
  for (const int guides : {1, 3, 16}) {
    EffectScene t;
    for (int i = 0; i < guides; ++i) {
      const auto id = t.addMesh(mesh, {}, {}, 0);
      t.set(id, effect(EffectKind::kGuide, 2, i + 1 < guides ? 1 : 50));  // The last one is the deepest.
    }
    for (int i = 0; i < 50; ++i) {
      const Vec3 x(0.001 * std::sin(0.3 * i), 0.001 * std::cos(0.3 * i), 0);
      EXPECT_NEAR(t.settled(x).norm(), 50 * 0.03, 50 * 0.004) << guides;
      EXPECT_GT(t.hand.visits(), std::min(guides * ObjectEffects::kMostVisits, ObjectEffects::kMostVisitsOfAll) - 100);
      EXPECT_LT(t.hand.visits(), ObjectEffects::kMostVisitsOfAll + 300);
    }
  }
}

TEST(ObjectEffects, AGuideDampsAlongItsWayToASurface) {
  EffectScene t;
  const auto ball = t.add(ShapeKind::kSphere, {0.02, 0, 0});
  t.set(ball, effect(EffectKind::kGuide, 2, 200, 5));
  expectForce(t.settled({0.025, 0, 0}, {0.1, 0.3, -0.2}), {-1.5, 0, 0});
  expectForce(t.settled({0.02, 0, 0}, {0.1, 0.3, -0.2}), Vec3::Zero());
}

TEST(ObjectEffects, AGuideDampsAcrossItsWayAndNotMoreThanItPulls) {
  EffectScene t;
  t.add(test::along(effect(EffectKind::kGuide, 2, 200, 5), {{-0.1, 0, 0}, {0.1, 0, 0}}));
  expectForce(t.settled({0, 0.005, 0}, {3, 0, 0}), {0, -1, 0});
  expectForce(t.settled({0, 0.005, 0}, {0, 0.1, 0.1}), {0, -1.5, -0.5});
  expectForce(t.settled({0, 0.005, 0}, {0, 10, 0}), {0, -2, 0});
}

TEST(ObjectEffects, OfEqualGuidesTheNearestActsAndTheDeeperOfUnequalOnes) {
  EffectScene t;
  t.add(effect(EffectKind::kGuide, 2, 200), {{-0.02, 0, 0}, Quat::Identity()});
  t.add(effect(EffectKind::kGuide, 2, 200), {{0.02, 0, 0}, Quat::Identity()});
  expectForce(t.settled({0.001, 0, 0}), {2, 0, 0});
  expectForce(t.settled({-0.001, 0, 0}), {-2, 0, 0});
  t.add(effect(EffectKind::kGuide, 20, 2000), {{0, 0.04, 0}, Quat::Identity()});
  expectForce(t.settled({0.001, 0.012, 0}).normalized(), Vec3(-0.001, 0.028, 0).normalized());
}

TEST(ObjectEffects, EndAtTheirTimeWithoutAJump) {
  EffectScene t;
  EffectParameters bounded = effect(EffectKind::kForce, 1);
  bounded.until_ns = 100'000'000;
  (void)t.feel({0, 0, 0});
  t.add(bounded);
  double before = 0;
  for (int i = 2; i < 140; ++i) {
    const double f = t.feel({0, 0, 0}).z();
    EXPECT_LE(std::abs(f - before), 0.051) << i;
    if (i > 25 && i <= 100) {
      EXPECT_NEAR(f, 1, 1e-9);
    }
    if (i > 120) {
      EXPECT_NEAR(f, 0, 1e-9);
    }
    before = f;
  }
}

TEST(ObjectEffects, AGuideThatEndsHandsOverWithoutAJump) {
  EffectScene t;
  EffectParameters bounded = effect(EffectKind::kGuide, 4, 400);
  bounded.until_ns = 100'000'000;
  t.add(bounded, {{0.01, 0, 0}, Quat::Identity()});
  t.add(effect(EffectKind::kGuide, 4, 400), {{-0.02, 0, 0}, Quat::Identity()});
  double before = t.feel({0, 0, 0}).x();
  EXPECT_NEAR(before, 4, 1e-9);
  for (int i = 0; i < 160; ++i) {
    const double f = t.feel({0, 0, 0}).x();
    // 4 N fade over 20 ms, and with them what is left of 8 N between the two.
    EXPECT_LE(std::abs(f - before), 8 / 20.0 + 4 / 20.0 + 1e-9) << i;
    if (i > 130) {
      EXPECT_NEAR(f, -4, 1e-9) << "as soon as the other is the deeper one, not when this has gone";
    }
    before = f;
  }
  EXPECT_NEAR(before, -4, 1e-9);
}

TEST(ObjectEffects, ThatAreSetOrRemovedOrWhoseObjectJumpsComeAndGoWithoutAJump) {
  EffectScene t;
  (void)t.feel({0, 0, 0});
  const auto id = t.add(effect(EffectKind::kForce, 2));
  double before = 0;
  const auto run = [&](double end) {
    for (int i = 0; i < 25; ++i) {
      const double f = t.feel({0, 0, 0}).z();
      EXPECT_LE(std::abs(f - before), 0.101);
      before = f;
    }
    EXPECT_NEAR(before, end, 1e-9);
  };
  run(2);
  t.set(id, effect(EffectKind::kForce, 1));
  run(1);
  t.pose(id, {{3, 0, 0}, Quat::Identity()});
  run(0);
  t.pose(id, {});
  run(1);
  t.remove(id);
  run(0);
}

TEST(ObjectEffects, AHandThatIsSomewhereElseHasAllOfTheForceAtOnce) {
  EffectScene t;
  (void)t.feel({0, 0, 0});
  t.add(effect(EffectKind::kForce, 2));
  t.add(effect(EffectKind::kFriction, 1, 1000));
  (void)t.feel({0, 0, 0});
  t.hand.reset();
  expectForce(t.feel({0.0005, 0, 0}), {0, 0, 2}, 1e-12);
  t.add(effect(EffectKind::kForce, 1));
  t.hand.reset();
  expectForce(t.feel({0.0005, 0, 0}), {0, 0, 3}, 1e-12);
}

TEST(ObjectEffects, ThatAreSetInEveryTickAreFeltAllTheSame) {
  EffectScene t;
  const auto id = t.add(effect(EffectKind::kForce, 1));
  for (int i = 0; i < 200; ++i) {
    t.set(id, effect(EffectKind::kForce, 1));
    (void)t.feel({0, 0, 0});
  }
  EXPECT_NEAR(t.feel({0, 0, 0}).z(), 1, 1e-3);
}

/** Else a guide is a spring that answers 20 ms late, with which a hand swings up. */
TEST(ObjectEffects, OrdersInEveryTickDelayNothingThatTheHandDoes) {
  for (const bool guide_itself : {false, true}) {
    EffectScene t;
    const auto guide = t.add(effect(EffectKind::kGuide, 2, 200, 4)), other = t.add(effect(EffectKind::kForce, 0));
    t.add(effect(EffectKind::kFriction, 0.2, 100));
    t.pose(guide, {}, {{0, -0.1, 0}, Vec3::Zero()});
    double dragged = 0;
    for (int i = 0; i < 60; ++i) {
      const double x = 1e-4 * i, change = 1e-9 * (i % 2);
      if (guide_itself) t.set(guide, effect(EffectKind::kGuide, 2, 200 + change, 4));
      if (!guide_itself) t.set(other, effect(EffectKind::kForce, 1 + i % 2));
      const Vec3 force = t.feel({x, 0, 0}, {0.1, 0, 0});
      dragged = std::max(dragged, std::abs(force.z()));
      if (i < 21) continue;  // Its pull bounds its damping.
      const double rubs = std::min(0.2, 100 * x), y = x;
      EXPECT_NEAR(force.x(), -200 * x - 0.4 - rubs, 1e-6) << i;
      EXPECT_NEAR(force.y(), -200 * y - 0.4, 1e-6) << i;
    }
    EXPECT_NEAR(dragged, guide_itself ? 0 : 1.5, 0.15);
  }
}

TEST(ObjectEffects, AGuideThatFollowsTheHandPullsNoHarderThanItMay) {
  for (const int every : {1, 2, 3}) {
    EffectScene t;
    const auto acrossAt = [](double x) {
      return test::along(effect(EffectKind::kGuide, 2, 4000), {{x, -1, 0}, {x, 1, 0}});
    };
    const auto guide = t.add(acrossAt(0));
    double most = 0;
    for (int i = 0; i < 100; ++i) {
      if (i % every == 0) t.set(guide, acrossAt(3e-4 * (i - 1)));
      most = std::max(most, t.feel({3e-4 * i, 0, 0}, {0.3, 0, 0}).norm());
    }
    EXPECT_LE(most, 2 + 1e-9) << every;
    EXPECT_GT(most, 1.1) << "where it was 20 ms ago, or a tick";
  }
}

TEST(ObjectEffects, TheSameOnceMoreIsNoChange) {
  EffectScene t;
  const auto id = t.add(test::along(effect(EffectKind::kForce, 1), {{-1, 0, 0}, {1, 0, 0}}));
  (void)t.settled({0, 0, 0});
  EffectParameters more = test::along(effect(EffectKind::kForce, 2), {{-1, 0, 0}, {1, 0, 0}});
  t.set(id, more);
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(t.feel({0, 0, 0}).z(), 1.05 + 0.05 * i, 1e-9) << "over 20 ms, whatever is said meanwhile";
    more.path[2][0] = static_cast<float>(i);  // Beyond its last point.
    t.set(id, more);
    t.flags(id, HD_OBJECT_TWO_SIDED, 0);
  }
  const std::uint64_t before = t.scene->effectChanges();
  more.path[1][0] = 2;
  t.set(id, more);
  EXPECT_NE(t.scene->effectChanges(), before);
}

TEST(ObjectEffects, GoWithTheObjectAboveAndOnItsSpeed) {
  EffectScene t;
  const auto hand = t.TestScene::add(ShapeKind::kGroup, Vec3::Zero());
  const auto id = t.TestScene::add(ShapeKind::kGroup, Vec3::Zero(), {{0, 0, 0.01}, Quat::Identity()}, {}, 0, hand);
  t.set(id, effect(EffectKind::kGuide, 2, 200));
  (void)t.settled({0, 0, 0.01});
  t.pose(hand, {{0, 0, 0.005}, Quat::Identity()});
  expectForce(t.settled({0, 0, 0.01}), {0, 0, 1});
}

TEST(ObjectEffects, RefusesWhatIsNoEffectAndMoreThanThereMayBe) {
  EffectScene t;
  const auto id = t.TestScene::add(ShapeKind::kGroup, Vec3::Zero());
  EXPECT_EQ(t.set(id + 1, effect(EffectKind::kForce)), ErrorCode::kNotFound);
  const auto refused = [&](auto&& spoil) {
    EffectParameters e = test::along(effect(EffectKind::kGuide), {{0, 0, 0}, {1, 0, 0}});
    spoil(e);
    EXPECT_EQ(t.set(id, e), ErrorCode::kInvalidArgument);
  };
  refused([](auto& e) { e.kind = 6; });
  refused([](auto& e) { e.points = 1; });
  refused([](auto& e) { e.points = kMaxPathPoints + 1; });
  refused([](auto& e) { e.path[1][2] = NAN; });
  refused([](auto& e) { e.force = -1; });
  refused([](auto& e) { e.stiffness = NAN; });
  refused([](auto& e) { e.damping = INFINITY; });
  refused([](auto& e) { e.frequency = -1; });
  refused([](auto& e) { e.reach = 0; });
  EXPECT_TRUE(t.scene->effects().empty());
  for (std::uint32_t i = 0; i < kMaxEffects; ++i) t.add(effect(EffectKind::kForce));
  EXPECT_EQ(t.set(id, effect(EffectKind::kForce)), ErrorCode::kQuotaExceeded);
  EXPECT_EQ(t.remove(makeObjectId(5, 1)), ErrorCode::kOk);
  EXPECT_EQ(t.set(id, effect(EffectKind::kForce)), ErrorCode::kOk);
  EXPECT_EQ(t.scene->effects().size(), kMaxEffects);
}

}  // namespace
}  // namespace hapticd
