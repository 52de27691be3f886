// What local models tell the guard of their force: which part of it is active, what moving and blending them puts in,
// and what they hold.
#include "tests/unit/render/slot_rig.h"

namespace hapticd {
namespace {

using SlotEnergyTest = SlotTest;

/** Of a blend what springs make is active, and what planes make is not, also where one breaks off another. */
TEST_F(SlotEnergyTest, OfABlendTheSpringsPartIsActive) {
  const auto spring = [&](double y) {
    hd_local_model m = modelOf(HD_MODEL_SPRING, 300);
    m.origin[1] = y;
    return m;
  };
  const auto expectActive = [&](std::int64_t ms, const Vec3& passive) {
    const ModelForce f = slot.evaluate(tool, now + ms * kMs, scene);
    EXPECT_LT((f.force - f.active - passive).norm(), 1e-12) << ms << ": " << (f.force - f.active).transpose();
    EXPECT_GT(f.force.norm(), 0.1) << ms;
  };
  set(spring(0.01), 0);
  for (int ms = 0; ms <= 20; ++ms) (void)at(ms);
  set(spring(-0.02), 21);
  for (int ms = 21; ms < 25; ++ms) expectActive(ms, Vec3::Zero());
  set(spring(0.03), 25);
  for (int ms = 25; ms < 29; ++ms) expectActive(ms, Vec3::Zero());
  set(modelOf(HD_MODEL_PLANE), 29);  // 1 N.
  for (int ms = 29; ms < 45; ++ms) expectActive(ms, {0, 0, std::min(1.0, (ms - 28) / 10.0)});
  set(spring(0.01), 45);
  for (int ms = 45; ms < 60; ++ms) expectActive(ms, {0, 0, std::max(0.0, 1 - (ms - 44) / 10.0)});
}

TEST_F(SlotEnergyTest, OfWhatFadesTheSpringsPartIsActiveToo) {
  hd_local_model m = modelOf(HD_MODEL_SPRING, 300);
  m.origin[1] = 0.01;
  m.lease_ns = 100 * kMs;
  set(m, 0);
  for (int ms = 0; ms < 140; ++ms) (void)at(ms);
  const ModelForce f = slot.evaluate(tool, now + 140 * kMs, scene);
  EXPECT_GT(f.force.norm(), 0.1);
  EXPECT_LT((f.force - f.active).norm(), 1e-12);
}

/** Who moves both of them pays for the force of both, as far as each has it; a softer one puts in nothing itself. */
TEST_F(SlotEnergyTest, OfABlendWhatMovesItIsCharged) {
  const Vec3 v(0.03, 0, 0.2);
  hd_local_model m = modelOf(HD_MODEL_PLANE, 1500);
  m.frame = addObject({0, 0, 0.002}, v);
  set(m, 0);
  for (int ms = 0; ms < 15; ++ms) (void)at(ms);
  m.material.stiffness = 500;
  set(m, 15);
  EXPECT_FLOAT_EQ(slot.status(now + 15 * kMs).weight, 0.1F);
  for (int ms = 15; ms < 30; ++ms) {
    const ModelForce f = slot.evaluate(tool, now + ms * kMs, scene);
    EXPECT_GT(f.force.z(), 0.9);
    EXPECT_LT((f.carried - f.force.cwiseProduct(v)).norm(), 1e-12) << ms;
  }
  EXPECT_FLOAT_EQ(slot.status(now + 30 * kMs).weight, 1);
  slot.clear(now + 30 * kMs, 10 * kMs);
  EXPECT_NEAR(slot.status(now + 33 * kMs).weight, 0.6, 1e-6);
}

/** Where it stays it moves no more: it pushes nobody, whatever the object did in its last tick. */
TEST_F(SlotEnergyTest, RestsWhenItsObjectIsGoneInMidMotion) {
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.frame = addObject({0, 0, 0.05}, {0, 0, 0.1});
  set(m, 0);
  (void)at(0);
  tool.p.z() = 0.048;
  (void)at(20);
  ASSERT_NEAR(slot.evaluate(tool, now + 21 * kMs, scene).carried.z(), 0.1, 1e-9);
  ASSERT_EQ(scene.apply(makeCommand(CommandKind::kRemoveObject, ObjectRef{m.frame})), ErrorCode::kOk);
  const ModelForce gone = slot.evaluate(tool, now + 22 * kMs, scene);
  EXPECT_NEAR(gone.force.z(), 1, 1e-9);
  EXPECT_EQ(gone.carried.z(), 0);
}

TEST_F(SlotEnergyTest, WhatABlendPutsInIsBooked) {
  set(modelOf(HD_MODEL_PLANE, 500), 0);
  double put_in = 0;
  for (int ms = 0; ms < 20; ++ms) {
    put_in += slot.evaluate(tool, now + ms * kMs, scene).carried.sum() * 1e-3;
  }
  EXPECT_NEAR(put_in, 0.5 * 500 * 4e-6, 1e-12) << "the energy of a plane that appears 2 mm about the hand";
  const ModelForce f = slot.evaluate(tool, now + 20 * kMs, scene);
  EXPECT_NEAR(f.stored, 0.5 * 500 * 4e-6, 1e-12);
  EXPECT_EQ(f.carried, Vec3(0, 0, 0));
  EXPECT_EQ(f.active, Vec3(0, 0, 0));
  hd_local_model spring = modelOf(HD_MODEL_SPRING);
  set(spring, 21);
  (void)at(21);
  const ModelForce s = slot.evaluate(tool, now + 40 * kMs, scene);
  EXPECT_EQ(s.active, s.force) << "springs are active sources";
}

/** What a blend puts in is booked along the change of the force, also where it breaks off another one. */
TEST_F(SlotEnergyTest, WhatABlendPutsInIsAlongTheChange) {
  const auto wall = [&](double x, double depth) {
    hd_local_model m = modelOf(HD_MODEL_PLANE);
    store(Vec3(x, 0, std::sqrt(1 - x * x)), m.normal);
    store(tool.p + depth * vec3(m.normal), m.origin);
    return m;
  };
  for (const int broken_off : {20, 14, 11, 6}) {  // That many milliseconds after it has begun.
    slot.reset();
    set(wall(0, 0.002), 0);
    for (int ms = 0; ms < 20; ++ms) (void)at(ms);
    set(wall(-0.6, 0.003), 20);
    for (int ms = 20; ms < 20 + broken_off; ++ms) (void)at(ms);
    const int ms = 20 + broken_off;
    const ModelForce before = slot.evaluate(tool, now + ms * kMs, scene);
    set(wall(0.8, 0.006), ms);
    Vec3 put_in = Vec3::Zero();
    for (int i = 1; i <= 20; ++i) put_in += 1e-3 * slot.evaluate(tool, now + (ms + i) * kMs, scene).carried;
    const ModelForce after = slot.evaluate(tool, now + (ms + 21) * kMs, scene);
    EXPECT_NEAR(after.stored, 0.5 * 500 * 36e-6, 1e-9);
    const Vec3 wanted = byAxis(after.stored - before.stored, after.force - before.force);
    EXPECT_LT((put_in - wanted).norm(), 1e-9)
        << broken_off << ": " << put_in.transpose() << " / " << wanted.transpose();
  }
}

/** Of what fades as much is charged for, and held, as is felt. */
TEST_F(SlotEnergyTest, WhatFadesIsChargedAndHoldsInTheSameMeasure) {
  const Vec3 v(0.01, 0, 0.2);
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.lease_ns = 100 * kMs;
  m.frame = addObject({0, 0, 0.002}, v);
  set(m, 0);
  for (int ms = 0; ms <= 100; ++ms) (void)at(ms);
  const double force = at(100).z();
  ASSERT_GT(force, 0.5);
  for (int ms = 101; ms < 150; ++ms) {
    const double left = 1 - (ms - 100) / 50.0;
    const ModelForce f = slot.evaluate(tool, now + ms * kMs, scene);
    ASSERT_LT((f.force - left * Vec3(0, 0, force)).norm(), 1e-12) << ms;
    ASSERT_LT((f.carried - f.force.cwiseProduct(v)).norm(), 1e-12) << ms;
    ASSERT_NEAR(f.stored, left * force * force / (2 * 500), 1e-12) << ms;
  }
}

}  // namespace
}  // namespace hapticd
