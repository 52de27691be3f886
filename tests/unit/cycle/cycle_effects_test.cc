// What objects do in free space has its own share of the force, beside what they are to the touch, and in any hand.
#include <gtest/gtest.h>

#include "rt/cycle/cycle_start.h"
#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/test_effect.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kWall = makeObjectId(1, 1), kGuide = makeObjectId(2, 1);

/** A wall at z = 0, and a line along x at z = 10 mm that draws the hand up. */
struct Guided : test::SteppedCycle {
  explicit Guided(double limit = 20) : SteppedCycle(test::openConfig(limit)) {
    add(test::solid(kWall, ShapeKind::kPlane, {1000, 0, 0, 0}));
    add(test::solid(kGuide, ShapeKind::kGroup, {}, {{0, 0, 0.01}, Quat::Identity()}));
    arm();
    for (int i = 0; i < 10; ++i) (void)at({0, 0, 0.05});
    put(CommandKind::kSetEffect,
        SetEffect{kGuide, 0, test::along(test::effect(EffectKind::kGuide, 2, 100), {{-0.1, 0, 0}, {0.1, 0, 0}})});
  }
  const DeviceOutput& settled(const Vec3& p) {
    const Vec3 from = input->device[0].p;
    for (int i = 1; i <= 200; ++i) (void)at(from + i / 200.0 * (p - from));
    return at(p);
  }
};

TEST(CycleEffects, HaveTheirOwnShareBesideTheSurfaces) {
  Guided hand;
  const GuardOutput& free = hand.settled({0, 0, 0.004}).guard;
  EXPECT_NEAR(free.by_source[HD_SOURCE_EFFECT].z(), 0.6, 1e-6);
  EXPECT_NEAR(free.command.force.z(), 0.6, 1e-6);
  const GuardOutput& pressed = hand.settled({0, 0, -0.002}).guard;
  EXPECT_NEAR(pressed.by_source[HD_SOURCE_EFFECT].z(), 1.2, 1e-6);
  EXPECT_NEAR(pressed.by_source[HD_SOURCE_SURFACE].z(), 2, 1e-6);
  EXPECT_NEAR(pressed.command.force.z(), 3.2, 1e-6);
}

TEST(CycleEffects, AreBoundByTheGuard) {
  Guided hand(1);
  EXPECT_NEAR(hand.settled({0, 0, -0.003}).guard.command.force.norm(), 1, 1e-9);
}

/** A bath thicker than a device can show is as thick as that, in newtons a metre of the hand: also in a larger world.
 */
TEST(CycleEffects, DampNoMoreThanTheDeviceCanShow) {
  for (const double scale : {1.0, 2.0}) {
    CycleConfig config = test::openConfig(20);
    config.guard[0].max_damping = 10;
    test::SteppedCycle hand(config);
    if (scale != 1) hand.put(CommandKind::kSetMount, test::mountAt({}, 0, scale));
    hand.add(test::solid(kGuide, ShapeKind::kGroup, {}));
    hand.put(CommandKind::kSetEffect, SetEffect{kGuide, 0, test::effect(EffectKind::kViscous, 20, 0, 100, 10)});
    hand.arm();
    for (int i = 0; i < 10; ++i) (void)hand.at(Vec3::Zero());
    double force = 0;
    for (int i = 0; i < 300; ++i) force = hand.at({1e-4 * i, 0, 0}).guard.command.force.x();
    EXPECT_NEAR(force, -1, 1e-6) << "10 N s/m at 0.1 m/s, scale " << scale;
  }
}

TEST(CycleEffects, AreFeltByAHandThatHoldsATool) {
  Guided hand;
  hand.add(test::solid(makeObjectId(3, 1), ShapeKind::kSphere, {500, 0, 0, 0}, {{0, 0, 0.1}, Quat::Identity()},
                       {0.001, 0, 0}));
  (void)hand.settled({0, 0, 0.1});
  hand.put(CommandKind::kAttachTool, test::attachBox(makeObjectId(3, 1), {0.02, 0.02, 0.02}, DeviceInfo{}));
  EXPECT_NEAR(hand.settled({0, 0, 0.02}).guard.by_source[HD_SOURCE_EFFECT].z(), -1, 1e-6);
}

TEST(CycleEffects, AreThereAtOnceInACycleMadeAnew) {
  CycleStart start;
  start.config = test::openConfig(20);
  start.orders = {makeCommand(CommandKind::kAddObject, test::solid(kGuide, ShapeKind::kGroup, {})),
                  makeCommand(CommandKind::kSetEffect, SetEffect{kGuide, 0, test::effect(EffectKind::kForce, 0.1)})};
  test::SteppedCycle hand;
  hand.cycle = makeCycle(start, hand.meshes);
  hand.arm();
  double most = 0;
  for (int i = 0; i < 10; ++i) most = std::max(most, hand.at({0, 0, 0}).guard.command.force.z());
  EXPECT_NEAR(most, 0.1, 1e-9) << "within ten ticks, not blended in over twenty";
}

}  // namespace
}  // namespace hapticd
