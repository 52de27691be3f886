#include "rt/render/model/local_model.h"

#include <gtest/gtest.h>

#include "tests/unit/render/slot_rig.h"

namespace hapticd {
namespace {

TEST_F(SlotTest, BlendsInFromNothing) {
  set(modelOf(HD_MODEL_PLANE), 0);
  for (int ms = 0; ms <= 10; ++ms) EXPECT_NEAR(at(ms).z(), ms / 10.0, 1e-12);
  EXPECT_NEAR(at(11).z(), 1, 1e-12);
  EXPECT_EQ(slot.status(now + 11 * kMs).state, 2u);
  EXPECT_EQ(slot.status(now + 11 * kMs).age_ns, 11 * kMs);
  EXPECT_EQ(slot.status(now + 11 * kMs).seq, 1u);
}

/** In the middle of its blend; then once more, in the middle of that. */
TEST_F(SlotTest, WhatIsClearedIsToldToFadeFromWhereItWasAndToGrowOlder) {
  set(modelOf(HD_MODEL_PLANE), 0);
  for (int ms = 0; ms <= 4; ++ms) (void)at(ms);
  slot.clear(now + 5 * kMs, 20 * kMs);
  for (int ms = 5; ms < 29; ++ms) {
    if (ms == 15) slot.clear(now + ms * kMs, 20 * kMs);
    const double told = slot.status(now + ms * kMs).weight;
    EXPECT_NEAR(told, at(ms).z(), 1e-7) << ms << ": 1 N in force";
    EXPECT_LT(told, 0.4);
    EXPECT_EQ(slot.status(now + ms * kMs).age_ns, ms * kMs);
    EXPECT_EQ(slot.status(now + ms * kMs).state, 3u);
  }
}

TEST_F(SlotTest, BlendsLinearlyFromOneModelToTheNext) {
  set(modelOf(HD_MODEL_PLANE, 500), 0);
  (void)at(0);
  (void)at(20);
  set(modelOf(HD_MODEL_PLANE, 1500), 21);
  for (int ms = 1; ms <= 10; ++ms) EXPECT_NEAR(at(20 + ms).z(), 1 + 2 * ms / 10.0, 1e-12);
}

TEST_F(SlotTest, ModelsReplacedInEveryTickComeIntoForce) {
  // What is missing falls by dt / blend in each tick, so that a client as fast as the servo is felt, one blend late.
  double missing = 1;
  for (int ms = 0; ms < 100; ++ms) {
    set(planeAgain(), ms);
    EXPECT_NEAR(at(ms).z(), 1 - missing, 1e-12);
    missing *= 0.9;
  }
}

/** They say the same of the same place: what they replace in mid-blend follows the hand as they do. */
TEST_F(SlotTest, ModelsThatAgreeFollowTheHandHoweverOftenTheyAreReplaced) {
  for (int ms = 0; ms < 300; ++ms) {
    set(planeAgain(), ms);
    tool.p.z() = -0.004 + 0.003 * std::sin(0.05 * ms);
    const double wanted = -500 * tool.p.z(), felt = at(ms).z();
    if (ms <= 120) continue;
    ASSERT_NEAR(felt, wanted, 1e-4 * wanted) << ms;
  }
}

/** What the old model does not explain stays as it was, and goes: a hand that leaves is not drawn back. */
TEST_F(SlotTest, AHandThatLeavesInMidBlendIsNotPulled) {
  for (int ms = 0; ms < 4; ++ms) {
    set(planeAgain(), ms);
    (void)at(ms);
  }
  tool.p.z() = 0.001;
  for (int ms = 4; ms < 30; ++ms) {
    set(planeAgain(), ms);
    ASSERT_NEAR(at(ms).z(), 0, 1e-12) << ms;
  }
}

/** In the air they have agreed that there is nothing: taps of a hand meet the whole plane, and get nothing from it. */
TEST_F(SlotTest, AHandThatComesToASurfaceMeetsAllOfItHoweverOftenItIsReplaced) {
  for (const int blend_ms : {5, 10, 50}) {
    for (const int every : {1, 2, 7}) {
      slot.reset();
      double most = 0, work = 0, before = 0;
      const auto height = [](int ms) { return std::abs(ms % 200 - 100) * 1e-4 - 0.002; };  // To 2 mm deep, at 0.1 m/s.
      for (int ms = 0; ms < 1000; ++ms) {
        hd_local_model m = planeAgain();
        m.blend_ns = blend_ms * kMs;
        if (ms % every == 0) set(m, ms);
        tool.p.z() = height(ms);
        const double force = at(ms).z();
        if (ms < 400) continue;
        most = std::max(most, force);
        work += (force + before) / 2 * (height(ms) - height(ms - 1));
        before = force;
      }
      EXPECT_NEAR(most, 1, 1e-3) << blend_ms << " " << every;
      EXPECT_NEAR(work, 0, 1e-6) << blend_ms << " " << every << ": of the three times 1 mJ that went in";
    }
  }
}

/** One that is in force and is sent again is felt as if it had not been: not a bit changes, whatever the surface. */
TEST_F(SlotTest, SentAgainAModelOnlyHasItsLeaseRenewed) {
  for (const bool round : {false, true}) {
    for (const double friction : {0.0, 0.7}) {
      slot.reset();
      LocalModelSlot other;
      hd_local_model m = modelOf(round ? HD_MODEL_SPHERE : HD_MODEL_PLANE, 500, 2);
      if (round) m.origin[2] = -0.02;
      m.material.friction_static = friction;
      m.material.friction_dynamic = 0.6 * friction;
      m.lease_ns = 5000 * kMs;
      ASSERT_EQ(other.set(commandOf(m), now, scene), ErrorCode::kOk);
      m.lease_ns = 100 * kMs;
      for (int ms = 0; ms < 3000; ++ms) {
        if (ms > 0) m.blend_ns = (5 + ms % 40) * kMs;
        if (ms % 37 == 0 || ms % 100 < 10) set(m, ms);
        tool.p = Vec3(0.004 * std::sin(0.01 * ms), 0.002 * std::sin(0.023 * ms), 0.003 * std::sin(0.017 * ms) - 0.001);
        tool.v = Vec3(0.04 * std::cos(0.01 * ms), 0.046 * std::cos(0.023 * ms), 0.051 * std::cos(0.017 * ms));
        ASSERT_EQ(at(ms), other.evaluate(tool, now + ms * kMs, scene).force) << round << " " << friction << " " << ms;
      }
      EXPECT_FALSE(slot.takeExpired());
    }
  }
}

/** A surface whose material changes by next to nothing keeps a hand where it sticks, round or flat. */
TEST_F(SlotTest, AnotherMaterialKeepsWhatSticksWhereItIs) {
  LocalModelSlot other;
  hd_local_model m = modelOf(HD_MODEL_SPHERE);
  m.origin[2] = -0.02;
  m.lease_ns = 5000 * kMs;
  m.material.friction_static = 0.7;
  m.material.friction_dynamic = 0.4;
  ASSERT_EQ(other.set(commandOf(m), now, scene), ErrorCode::kOk);
  for (int ms = 0; ms < 3000; ++ms) {
    m.material.stiffness = 500 + 1e-9 * ms;
    set(m, ms);
    tool.p = Vec3(0.004 * std::sin(0.01 * ms), 0.002 * std::sin(0.023 * ms), 0.002 * std::sin(0.017 * ms) - 0.003);
    const Vec3 alone = other.evaluate(tool, now + ms * kMs, scene).force, force = at(ms);
    if (ms <= 200) continue;
    ASSERT_LT((force - alone).norm(), 1e-3) << ms;
  }
}

/** What is more than all of the old model is a part that no hand changes: as stiff as that model it goes, not stiffer.
 */
TEST_F(SlotTest, OfAModelNoMoreThanAllOfItGoesOn) {
  set(modelOf(HD_MODEL_PLANE, 1500), 0);
  (void)at(0);
  (void)at(20);
  set(modelOf(HD_MODEL_PLANE, 500), 20);
  EXPECT_NEAR(at(21).z(), 0.1 * 1 + 0.9 * 3, 1e-12);
  hd_local_model away = modelOf(HD_MODEL_PLANE);
  away.origin[2] = -1;
  set(away, 21);
  tool.p.z() = -0.001;
  EXPECT_NEAR(at(22).z(), 0.9 * (0.5 + 1.8), 1e-12);
  tool.p.z() = 0.001;
  EXPECT_NEAR(at(23).z(), 0.8 * 1.8, 1e-12);
}

TEST_F(SlotTest, WhatItDampsByIsBlendedAndFadesAsTheForceDoes) {
  const auto damping = [&](std::int64_t ms) { return slot.evaluate(tool, now + ms * kMs, scene).damping; };
  set(modelOf(HD_MODEL_PLANE, 500, 2), 0);
  for (int ms = 0; ms <= 10; ++ms) EXPECT_NEAR(damping(ms), 2 * ms / 10.0, 1e-12);
  EXPECT_NEAR(damping(20), 2, 1e-12);
  set(modelOf(HD_MODEL_PLANE, 500, 6), 21);
  for (int ms = 1; ms <= 10; ++ms) EXPECT_NEAR(damping(20 + ms), 2 + 4 * ms / 10.0, 1e-12);
  for (int ms = 0; ms < 50; ++ms) EXPECT_NEAR(damping(1021 + ms), 6 * (1 - ms / 50.0), 1e-12);
  EXPECT_EQ(damping(1071), 0);
}

TEST_F(SlotTest, ShortestBlendIsKept) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.blend_ns = 0;
  set(m, 0);
  EXPECT_EQ(at(0).z(), 0);
  EXPECT_NEAR(at(1).z(), 0.2, 1e-12);
}

TEST_F(SlotTest, ReplacementInTheMiddleOfABlendDoesNotJump) {
  set(modelOf(HD_MODEL_PLANE, 500), 0);
  (void)at(0);
  (void)at(20);
  set(modelOf(HD_MODEL_PLANE, 1500), 20);
  (void)at(20);
  const double before = at(24).z();
  ASSERT_NEAR(before, 1.8, 1e-12);
  hd_local_model spring = modelOf(HD_MODEL_SPRING, 100);
  spring.origin[2] = -0.052;
  set(spring, 24);
  EXPECT_NEAR(at(24).z(), before, 1e-12);
  for (int ms = 1; ms <= 10; ++ms) EXPECT_NEAR(at(24 + ms).z(), before + ms / 10.0 * (-5 - before), 1e-9);
}

TEST_F(SlotTest, SeveralReplacementsWithinOneTickCountAsOne) {
  set(modelOf(HD_MODEL_PLANE, 500), 0);
  (void)at(0);
  (void)at(20);
  set(modelOf(HD_MODEL_PLANE, 5000), 21);
  set(modelOf(HD_MODEL_PLANE, 1500), 21);
  EXPECT_NEAR(at(21).z(), 1.2, 1e-12);
  EXPECT_NEAR(at(25).z(), 2, 1e-12);
}

TEST_F(SlotTest, LeaseRunsOutFadesAndIsToldOnce) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.lease_ns = 100 * kMs;
  set(m, 0);
  (void)at(0);
  EXPECT_NEAR(at(100).z(), 1, 1e-12);
  EXPECT_FALSE(slot.takeExpired());
  EXPECT_NEAR(at(101).z(), 1 - 1 / 50.0, 1e-12);
  EXPECT_EQ(slot.status(now + 101 * kMs).state, 3u);
  EXPECT_TRUE(slot.takeExpired());
  EXPECT_FALSE(slot.takeExpired());
  EXPECT_NEAR(at(125).z(), 0.5, 1e-12);
  EXPECT_EQ(at(150).z(), 0);
  EXPECT_TRUE(slot.empty());
  EXPECT_FALSE(slot.takeExpired());
}

/** Also by who asks when it is long over. */
TEST_F(SlotTest, ThatALeaseRanOutIsToldWhenTheModelHasGone) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.lease_ns = 100 * kMs;
  set(m, 0);
  (void)at(0);
  (void)at(101);
  (void)at(200);
  ASSERT_TRUE(slot.empty());
  EXPECT_TRUE(slot.takeExpired());
  EXPECT_FALSE(slot.takeExpired());
}

TEST_F(SlotTest, TheLeaseIsThatOfTheLastTimeItWasSent) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  for (const std::int64_t lease : {400, 50}) {
    slot.reset();
    m.lease_ns = 100 * kMs;
    set(m, 0);
    (void)at(0);
    m.lease_ns = lease * kMs;
    const std::uint64_t before = slot.status(now).seq;
    set(m, 20);
    EXPECT_NEAR(at(20 + lease).z(), 1, 1e-12);
    EXPECT_EQ(slot.status(now + 20 * kMs).seq, before + 1);
    EXPECT_LT(at(21 + lease).z(), 0.99) << lease;
  }
}

TEST_F(SlotTest, RenewedWhileItFadesItComesBackWithoutAJump) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.lease_ns = 100 * kMs;
  set(m, 0);
  (void)at(0);
  (void)at(100);
  EXPECT_NEAR(at(125).z(), 0.5, 1e-12);
  set(m, 125);
  EXPECT_NEAR(at(125).z(), 0.5, 1e-12);
  EXPECT_NEAR(at(130).z(), 0.75, 1e-12);
  EXPECT_NEAR(at(135).z(), 1, 1e-12);
}

TEST_F(SlotTest, ClearBlendsOut) {
  set(modelOf(HD_MODEL_PLANE), 0);
  (void)at(0);
  (void)at(20);
  slot.clear(now + 20 * kMs, 20 * kMs);
  EXPECT_EQ(slot.status(now + 21 * kMs).state, 3u);
  EXPECT_NEAR(at(20).z(), 1, 1e-12);
  EXPECT_NEAR(at(30).z(), 0.5, 1e-12);
  EXPECT_EQ(at(40).z(), 0);
  EXPECT_TRUE(slot.empty());
  EXPECT_FALSE(slot.takeExpired()) << "cleared, not expired";
}

TEST_F(SlotTest, UpdatesOfOneSurfaceKeepAStickingHandStuck) {
  const hd_local_model m = stickingPlane();
  for (int ms = 22; ms < 1000; ++ms) {
    if (ms % 16 == 0) set(m, ms);
    ASSERT_NEAR(at(ms).x(), -0.5, 1e-12) << "creeps at " << ms << " ms";
  }
}

/** What is cleared and said anew in one tick was never gone. */
TEST_F(SlotTest, ASurfaceClearedAndSaidAnewInOneTickKeepsAStickingHandStuck) {
  const hd_local_model m = stickingPlane();
  for (int ms = 22; ms < 100; ++ms) {
    if (ms % 16 == 0) {
      slot.clear(ms * kMs, 0);
      set(m, ms);
    }
    ASSERT_NEAR(at(ms).x(), -0.5, 1e-12) << "creeps at " << ms << " ms";
  }
}

/** However fast the surface goes with the hand that sticks to it, and however often it is said anew. */
TEST_F(SlotTest, UpdatesOfASurfaceThatMovesKeepAStickingHandStuckToo) {
  const Vec3 v(0.3, -0.2, 0);
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.material.friction_static = 0.8;
  m.material.friction_dynamic = 0.5;
  m.frame = addObject({0.4, 0, 0}, v);
  m.origin[0] = -0.4;
  const Vec3 begun = scene.find(m.frame)->X_WO.p;
  set(m, 0);
  (void)at(0);
  for (int ms = 1; ms < 400; ++ms) {
    scene.advance(1e-3);
    tool.p = scene.find(m.frame)->X_WO.p - begun + Vec3(ms > 20 ? 0.001 : 0, 0, -0.002);
    if (ms > 30 && ms % 3 == 0) {
      m.origin[1] = 1e-6 * ms;
      set(m, ms);
    }
    const Vec3 force = at(ms);
    if (ms > 20) {
      ASSERT_LT((force - Vec3(-0.5, 0, 1)).norm(), 1e-9) << ms << ": " << force.transpose();
    }
  }
}

TEST_F(SlotTest, AHandThatHungOnASpringMeetsAPlaneAnew) {
  hd_local_model plane = modelOf(HD_MODEL_PLANE), spring = modelOf(HD_MODEL_SPRING);
  plane.material.friction_static = plane.material.friction_dynamic = 0.5;
  set(plane, 0);
  (void)at(0);
  ASSERT_LT((at(20) - Vec3(0, 0, 1)).norm(), 1e-12);
  set(spring, 30);
  (void)at(30);
  tool.p.x() = 0.05;
  (void)at(50);
  set(plane, 60);
  (void)at(60);
  EXPECT_LT((at(80) - Vec3(0, 0, 1)).norm(), 1e-12) << "where it stuck before the spring is forgotten";
}

TEST_F(SlotTest, AnotherDevicesHandDoesNotHangOnTheAnchorOfTheFormer) {
  hd_local_model plane = modelOf(HD_MODEL_PLANE);
  plane.material.friction_static = plane.material.friction_dynamic = 0.5;
  set(plane, 0);
  (void)at(0);
  ASSERT_LT((at(20) - Vec3(0, 0, 1)).norm(), 1e-12);
  plane.device = 1;
  set(plane, 30);
  tool = {{0.05, 0, -0.002}, Vec3::Zero(), 1};
  (void)at(30);
  EXPECT_LT((at(50) - Vec3(0, 0, 1)).norm(), 1e-12);
}

TEST_F(SlotTest, FollowsItsObject) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.frame = addObject({0, 0, 0.05}, {0, 0, 0.1});
  set(m, 0);
  (void)at(0);
  tool.p.z() = 0.048;
  EXPECT_NEAR(at(20).z(), 1, 1e-9);
  scene.advance(1e-3);
  EXPECT_NEAR(at(21).z(), 1 + 500 * 0.1e-3, 1e-9);
}

TEST_F(SlotTest, FollowsItsObjectWhileItIsReplacedToo) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.frame = addObject({0, 0, 0.05}, {0, 0, 0.1});
  set(m, 0);
  (void)at(0);
  tool.p.z() = 0.048;
  ASSERT_NEAR(at(20).z(), 1, 1e-9);
  slot.clear(now + 20 * kMs, 20 * kMs);
  for (int ms = 21; ms < 40; ++ms) {
    scene.advance(1e-3);
    ASSERT_NEAR(at(ms).z(), (1 - (ms - 20) / 20.0) * (1 + 500 * 0.1e-3 * (ms - 20)), 1e-9) << ms;
  }
}

TEST_F(SlotTest, FadesWhereItWasWhenItsObjectIsGone) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.frame = addObject({0, 0, 0.05});
  set(m, 0);
  (void)at(0);
  tool.p.z() = 0.048;
  ASSERT_NEAR(at(20).z(), 1, 1e-9);
  ASSERT_EQ(scene.apply(makeCommand(CommandKind::kRemoveObject, ObjectRef{m.frame})), ErrorCode::kOk);
  EXPECT_NEAR(at(21).z(), 1, 1e-9);
  EXPECT_NEAR(at(46).z(), 0.5, 1e-9);
  EXPECT_EQ(at(71).z(), 0);
  EXPECT_FALSE(slot.takeExpired()) << "its lease had not run out";
  EXPECT_EQ(slot.set(commandOf(m), now, scene), ErrorCode::kNotFound);
}

TEST_F(SlotTest, ActsOnItsOwnDeviceOnly) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.device = 1;
  set(m, 0);
  EXPECT_EQ(at(20).z(), 0);
  tool.device = 1;
  EXPECT_NEAR(at(20).z(), 1, 1e-12);
  // Given to another device: both blend.
  m.device = 0;
  set(m, 21);
  EXPECT_NEAR(at(25).z(), 0.5, 1e-12);
  tool.device = 0;
  EXPECT_NEAR(at(25).z(), 0.5, 1e-12);
}

/** With what is left of its lease, and under the number it came with. */
TEST_F(SlotTest, WhatIsInForceIsSaidAnewForTheRestOfItsLease) {
  hd_local_model plane = modelOf(HD_MODEL_PLANE);
  hd_force_field field{};
  plane.lease_ns = field.lease_ns = 100 * kMs;
  field.radius = 0.1;
  for (const Command& said : {commandOf(plane, 5), commandOf(field)}) {
    slot.reset();
    Command again;
    EXPECT_FALSE(slot.restate(now, again)) << "nothing is there";
    ASSERT_EQ(slot.set(said, now, scene), ErrorCode::kOk);
    (void)at(0);
    ASSERT_TRUE(slot.restate(now + 99 * kMs, again));
    EXPECT_EQ(again.kind, said.kind);
    EXPECT_EQ(again.seq, said.seq);
    LocalModel model;
    ASSERT_EQ(model.set(again), ErrorCode::kOk);
    EXPECT_EQ(model.lease_ns(), 1 * kMs);
    EXPECT_FALSE(slot.restate(now + 100 * kMs, again)) << "it ends";
    slot.clear(now + 10 * kMs, 10 * kMs);
    EXPECT_FALSE(slot.restate(now + 10 * kMs, again)) << "cleared";
  }
  plane.frame = addObject({0, 0, 0});
  set(plane, 0);
  (void)at(0);
  Command again;
  ASSERT_TRUE(slot.restate(now + 1 * kMs, again));
  ASSERT_EQ(scene.apply(makeCommand(CommandKind::kRemoveObject, ObjectRef{plane.frame})), ErrorCode::kOk);
  (void)at(1);
  EXPECT_FALSE(slot.restate(now + 2 * kMs, again)) << "there is no such object any more";
}

TEST_F(SlotTest, RefusedModelChangesNothing) {
  set(modelOf(HD_MODEL_PLANE), 0);
  (void)at(0);
  (void)at(20);
  hd_local_model bad = modelOf(HD_MODEL_PLANE, 900);
  bad.normal[2] = 0;
  EXPECT_EQ(slot.set(commandOf(bad), now + 20 * kMs, scene), ErrorCode::kInvalidArgument);
  EXPECT_NEAR(at(40).z(), 1, 1e-12);
}

}  // namespace
}  // namespace hapticd
