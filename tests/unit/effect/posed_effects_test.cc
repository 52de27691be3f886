// Effects of objects that a program puts where they are, pose by pose.
#include <gtest/gtest.h>

#include <algorithm>

#include "rt/base/math.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

using test::effect;
using test::EffectScene;
using test::expectForce;
using test::kTick;

Pose at(double x, double turned = 0) { return {{x, 0, 0}, Quat(Eigen::AngleAxisd(turned, Vec3::UnitZ()))}; }

// A guide that was put 12 mm farther turned the force by 5.6 N within a tick.
TEST(PosedEffects, WhatIsPutElsewhereOnceComesOver20Milliseconds) {
  for (const double x : {0.002, 0.006, 0.012, 0.04, 0.1}) {
    EffectScene t;
    const auto id = t.add(effect(EffectKind::kGuide, 3, 500, 0, 0.04));
    const Vec3 p(0.005, 0, 0);
    (void)t.settled(p);
    Vec3 before = t.settled(p);
    expectForce(before, {-2.5, 0, 0});
    t.pose(id, at(x));
    const double all = x < 0.04 ? std::min(3.0, 500 * std::abs(x - 0.005)) : x < 0.1 ? 3 : 0;
    double most = 0;
    for (int i = 0; i < 21; ++i) {
      const Vec3 force = t.feel(p);
      most = std::max(most, (force - before).norm());
      before = force;
    }
    expectForce(before, {x > 0.005 ? (x < 0.1 ? std::min(all, t.settled(p).x()) : 0) : -all, 0, 0});
    // A fiftieth of the way counts as the motion of this tick, and is felt at once.
    EXPECT_LE(most, (before - Vec3(-2.5, 0, 0)).norm() * 0.05 + 500 * x / 50 + 1e-9) << x;
  }
}

TEST(PosedEffects, PosesAtAGraphicsProgramsPaceAreJoined) {
  EffectScene t;
  const auto id = t.add(effect(EffectKind::kGuide, 3, 500, 0, 0.04));
  Vec3 before = t.settled({0, 0, 0});
  double most = 0, farthest = 0;
  for (int tick = 0; tick < 500; ++tick) {
    const double x = 0.1 * kTick * tick;
    if (tick % 16 == 0) t.pose(id, at(x));  // 0.8 N at once.
    const Vec3 force = t.feel({x, 0, 0});   // The hand goes with it.
    if (tick >= 64) farthest = std::max(farthest, force.norm());
    most = std::max(most, (force - before).norm());
    before = force;
  }
  EXPECT_LT(most, 0.15);
  EXPECT_LT(farthest, 500 * 0.1 * 0.03) << "no more than 30 ms late";
}

// With 20 ms for each, half of the way at 500 Hz was felt as late as that.
TEST(PosedEffects, AreFeltNoLaterThanTheTimeBetweenTwoPoses) {
  for (const int every : {2, 3, 10}) {
    EffectScene t;
    const auto id = t.add(effect(EffectKind::kGuide, 3, 500, 0, 0.04));
    (void)t.settled({0, 0, 0});
    for (int tick = 0; tick < 300; ++tick) {
      const double x = 0.1 * kTick * tick;
      if (tick % every == 0) t.pose(id, at(x));
      const double late = x - t.feel({x - 0.002, 0, 0}).x() / 500 - (x - 0.002);  // Behind a guide that moves on.
      if (tick > 60) EXPECT_LE(std::abs(late), 0.1 * kTick * (every + 1)) << every << ", " << tick;
    }
  }
}

TEST(PosedEffects, AMotionThatPosesTellInEveryTickIsFeltAtOnce) {
  EffectScene t;
  const auto table = t.add(ShapeKind::kGroup, {0, 0, 0});
  const auto id = t.TestScene::add(ShapeKind::kGroup, {0, 0, 0}, at(0.05), {}, 0, table);
  ASSERT_EQ(t.set(id, effect(EffectKind::kGuide, 3, 500, 0, 0.04)), ErrorCode::kOk);
  (void)t.settled({0.05, 0, 0});
  for (int tick = 1; tick < 200; ++tick) {
    const double x = 0.1 * kTick * tick, turned = 0.5 * kTick * tick;
    t.pose(table, at(x, turned));
    const Vec3 guide = at(x, turned) * Vec3(0.05, 0, 0);
    const Vec3 way = guide - Vec3(0.05, 0, 0);
    const Vec3 force = t.feel({0.05, 0, 0});
    if (tick > 24 && way.norm() < 0.006) expectForce(force, 500 * way, 1e-4);
  }
}

TEST(PosedEffects, APoseThatItsVelocityHasReachedChangesNothing) {
  EffectScene t;
  const auto id = t.add(effect(EffectKind::kGuide, 3, 500, 0, 0.04));
  (void)t.settled({0, 0, 0});
  t.pose(id, at(0), {{0.1, 0, 0}, Vec3::Zero()});
  for (int tick = 1; tick < 100; ++tick) {
    const double x = 0.1 * kTick * (tick - 1);
    if (tick % 16 == 0) t.pose(id, at(x), {{0.1, 0, 0}, Vec3::Zero()});
    const Vec3 force = t.feel({x - 0.004, 0, 0});
    if (tick > 24) expectForce(force, {2, 0, 0}, 1e-6);
  }
}

}  // namespace
}  // namespace hapticd
