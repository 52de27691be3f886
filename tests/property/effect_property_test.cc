// What effects may never do, whatever the scene and the hand: give energy while they rest, push more than they may,
// jump when they are changed.
#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

using test::EffectScene;

EffectParameters anyEffect(Random& random, EffectKind kind) {
  EffectParameters e = test::effect(kind, random.in(0, 4), random.in(0, 500), random.in(0, 5), random.in(0.005, 0.08));
  e.frequency = random.in(0, 400);
  if (random.once(2)) {
    e.points = 2 + random.below(8u);
    for (std::uint32_t i = 0; i < e.points; ++i)
      for (float& x : e.path[i]) x = static_cast<float>(random.in(-0.05, 0.05));
  }
  return e;
}

/** With or without a shape, and what can be touched or not. */
std::uint32_t anyObject(Random& random, EffectScene& t) {
  const auto kind = static_cast<ShapeKind>(random.below(6u));
  const Vec3 size(random.in(0.01, 0.05), random.in(0.01, 0.05), random.in(0.01, 0.05));
  return t.TestScene::add(kind, size, random.pose(0.05), {1000, 0, 0, 0},
                          random.once(2) ? std::uint32_t{HD_OBJECT_ENABLED} : 0);
}

TEST(EffectProperty, GuidesThatRestGiveNothingOnAnyClosedWay) {
  forSeeds(20, [](unsigned seed) {
    Random random(seed);
    EffectScene t;
    double most = 0;
    for (int i = 0; i < 5; ++i) {
      EffectParameters e = anyEffect(random, EffectKind::kGuide);
      e.damping = 0;
      most = std::max(most, e.force);
      EXPECT_EQ(t.set(anyObject(random, t), e), ErrorCode::kOk);
    }
    std::vector<Vec3> corner;
    for (int i = 0; i < 6; ++i) corner.push_back(random.vector(0.08));
    Vec3 p = corner.front();
    Vec3 f = t.settled(p);
    double work = 0, length = 0;
    for (std::size_t i = 1; i <= corner.size(); ++i) {
      const Vec3 from = corner[i - 1], to = corner[i % corner.size()];
      const int steps = static_cast<int>((to - from).norm() / 10e-6) + 1;
      for (int s = 1; s <= steps; ++s) {
        const Vec3 next = from + (to - from) * (static_cast<double>(s) / steps);
        const Vec3 felt = t.feel(next);
        ASSERT_LE(felt.norm(), most * (1 + 1e-9));
        work += 0.5 * (f + felt).dot(next - p);
        length += (next - p).norm();
        f = felt;
        p = next;
      }
    }
    // Where the nearest place changes the force turns at once: up to a step is missed there, some tens of times.
    EXPECT_NEAR(work, 0, 30 * 10e-6 * most + 1e-5 * most * length) << "over " << length << " m";
  });
}

TEST(EffectProperty, FrictionAndViscousNeverGiveMoreThanTheyTookWhileTheyRest) {
  forSeeds(60, [](unsigned seed) {
    Random random(seed);
    EffectScene t;
    for (int i = 0; i < 4; ++i) {
      const EffectParameters e = anyEffect(random, random.once(2) ? EffectKind::kFriction : EffectKind::kViscous);
      EXPECT_EQ(t.set(anyObject(random, t), e), ErrorCode::kOk);
    }
    Vec3 p = random.vector(0.05), v = Vec3::Zero();
    (void)t.settled(p);
    double given = 0;
    for (int i = 0; i < 4000; ++i) {
      v += random.vector(0.02) - 0.01 * v - 0.2 * p;
      const Vec3 before = p;
      p += 1e-3 * v;
      // At the end of the step: a spring that is being stretched takes no less than the mean.
      given += t.feel(p, v).dot(p - before);
      ASSERT_LT(given, 1e-4) << i;
    }
    EXPECT_LT(given, 0);
  });
}

/**
 * A mass that is let go in drags of any thickness comes to rest, each of its ticks no faster than the last: the force
 * acts a tick late, so what it bears is less than half of its mass a tick.
 */
TEST(EffectProperty, NoDragThrowsWhatADeviceMoves) {
  forSeeds(60, [](unsigned seed) {
    Random random(seed);
    EffectScene t;
    for (int i = 0; i < 4; ++i) {
      EffectParameters e = anyEffect(random, EffectKind::kViscous);
      e.damping = random.once(2) ? 1000 : random.in(0, 1000);
      e.reach = 10;
      EXPECT_EQ(t.set(anyObject(random, t), e), ErrorCode::kOk);
    }
    const double mass = random.in(0.05, 0.5);
    t.hand.setMaxDamping(0.24 * mass / test::kTick);
    Vec3 p = random.vector(0.05), v = random.vector(1), force = Vec3::Zero();
    (void)t.settled(p);
    const double first = v.norm();
    for (int i = 0; i < 6000; ++i) {
      const double before = v.norm();
      v += test::kTick / mass * force;
      p += test::kTick * v;
      force = t.feel(p, v);
      ASSERT_LE(v.norm(), before * (1 + 1e-9) + 1e-12) << i;
      ASSERT_LE(force.dot(v), 1e-12) << i;
    }
    EXPECT_LT(v.norm(), first);
  });
}

/** Together they damp by no more than they may, by what they say, and each at most as it would alone. */
TEST(EffectProperty, DragsDampByWhatTheySayAndByNoMoreThanTheyMay) {
  forSeeds(60, [](unsigned seed) {
    Random random(seed);
    EffectScene all;
    std::vector<EffectScene> alone(4);
    for (EffectScene& one : alone) {
      EffectParameters e = anyEffect(random, EffectKind::kViscous);
      e.damping = random.once(3) ? 1000 : random.in(0, 30);
      e.force = random.once(4) ? 0 : random.in(0, 2);
      e.reach = 10;
      (void)all.add(e);
      (void)one.add(e);
    }
    const double may = random.in(0, 40);
    all.hand.setMaxDamping(may);
    for (int i = 0; i < 30; ++i) {
      const Vec3 p = random.vector(0.05), v = random.vector(random.once(2) ? 0.01 : 0.5);
      const Vec3 force = all.settled(p, v);
      double sum = 0;
      for (EffectScene& one : alone) sum += one.settled(p, v).norm();
      const double damps = force.norm() / v.norm();
      ASSERT_LE(damps, may * (1 + 1e-9));
      ASSERT_NEAR(damps, all.hand.damping(), 1e-9 * (1 + may));
      ASSERT_NEAR(force.norm(), std::min(sum, may * v.norm()), 1e-9) << "one that is too weak took from the others";
      ASSERT_LE((force.normalized() + v.normalized()).norm(), damps > 1e-6 ? 1e-6 : 2.0);
    }
  });
}

TEST(EffectProperty, WhateverIsOrderedTheForceIsBoundedAndDoesNotJump) {
  forSeeds(60, [](unsigned seed) {
    Random random(seed);
    EffectScene t;
    if (random.once(2)) t.hand.setMaxDamping(random.in(0, 10));
    std::vector<std::uint32_t> objects;
    for (int i = 0; i < 3; ++i) objects.push_back(anyObject(random, t));
    const Vec3 p = random.vector(0.05);
    Vec3 before = t.feel(p);        // The first step has all of its force at once.
    const double most = 3 * 4 + 4;  // Of each object 4 N; one of them may guide and damp.
    for (int i = 0; i < 3000; ++i) {
      if (random.once(5)) {
        const std::uint32_t id = objects[random.below(objects.size())];
        const auto kind = static_cast<EffectKind>(random.below(6u));
        EffectParameters e = anyEffect(random, kind == EffectKind::kVibration ? EffectKind::kForce : kind);
        if (random.once(4)) e.until_ns = t.now_ns + static_cast<std::int64_t>(random.in(0, 1e8));
        switch (random.below(4)) {
          case 0:
            (void)t.set(id, e);
            break;
          case 1:
            (void)t.setShape(id,
                             {static_cast<std::uint32_t>(random.below(6u)), 0, {0.02, random.in(0.01, 0.05), 0.03}});
            break;
          case 2:
            t.flags(id, HD_OBJECT_ENABLED, random.once(2) ? std::uint32_t{HD_OBJECT_ENABLED} : 0);
            break;
          default:
            (void)t.set(id, {});
        }
      }
      const Vec3 f = t.feel(p);
      ASSERT_TRUE(isFinite(f));
      ASSERT_LE(f.norm(), most);
      // The hand and the objects rest: only orders and ends change anything.
      ASSERT_LE((f - before).norm(), most * 2 * test::kTick / ObjectEffects::kBlend) << i;
      before = f;
    }
  });
}

}  // namespace
}  // namespace hapticd
