// Two fingers hold a block that falls: what friction bears by closed forms, and what must never grow.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/grasp_house.h"

namespace hapticd {
namespace {

using test::GraspHouse;

constexpr double kArm = 6e-3;  // Of the fingers here [m].

SetFinger finger(bool coupled, double damping = 2) {
  return {
      0, static_cast<std::uint32_t>(PadLaw::kLinear), coupled ? 0U : kFingerUncoupled, 1, 5.8e-3, kArm, 0.1, damping,
      0};
}

void wear(GraspHouse& house, SetFinger order) {
  for (order.device = 0; order.device < 2; ++order.device) house.send(CommandKind::kSetFinger, order);
}

/** Presses that deep, and lets the weight come on slowly, so that nothing swings. */
void grasp(GraspHouse& house, double depth) {
  for (int i = 0; i <= 100; ++i) {
    house.press(depth * i / 100);
    house.step();
  }
  const double full = house.block.gravity;
  for (int i = 1; i <= 400; ++i) {
    house.block.gravity = full * i / 400;
    house.letGo();
    house.step();
  }
  house.run(300);
}

/** How hard each finger presses when the block first yields, and whether it slides or turns then. */
struct Yields {
  double at = 0;  ///< [N]
  bool slides = false, turns = false;
};

/** The fingers let go, slowly. */
Yields release(GraspHouse& house, double depth, double until) {
  Yields out;
  for (double d = depth; d > until; d -= 5e-7) {
    house.press(d);
    house.step();
    out.slides = house.finger(0).contact.slip;
    out.turns = house.servo->cycle().finger(0).turning();
    if (!out.slides && !out.turns) continue;
    out.at = house.block.material.stiffness * d;
    break;
  }
  return out;
}

GraspHouse::Block offCentre(double lever) {
  GraspHouse::Block block;
  block.com = {0, lever, 0};
  block.material = {1000, 1, 0.8, 0.7};
  return block;
}

/** Thesis eq. 2.42 and 2.45, corrected: each finger bears half. Uncoupled it slides at P = m g / (2 mu), and turns at
 * P = m g L / (2 mu arm): first what asks for more, on either side of L_0 = arm. */
TEST(Grasp, UncoupledFingersLetSlideOrTurnWhereTheirOwnFrictionEnds) {
  for (const double lever : {0.5 * kArm, 2 * kArm}) {
    GraspHouse house(offCentre(lever));
    wear(house, finger(false));
    const double weight = house.block.mass * house.block.gravity, mu = house.block.material.friction_static;
    const double slides = weight / (2 * mu), turns = slides * lever / kArm;
    grasp(house, 5e-3);
    const double twist = house.servo->cycle().finger(0).twist(), half = weight * lever / 2;
    ASSERT_NEAR(std::abs(twist), half * std::cos(twist) / 0.1, 5e-3 * half / 0.1);
    const Yields yields = release(house, 5e-3, 0);
    EXPECT_NEAR(yields.at, std::max(slides, turns), 0.02 * yields.at);
    EXPECT_EQ(yields.slides, lever < kArm);
    EXPECT_EQ(yields.turns, lever > kArm);
  }
}

/** Eq. 2.48: together they yield at (m g / 2 mu P)^2 + (m g L / 2 mu arm P)^2 = 1, and then both. */
TEST(Grasp, CoupledFingersLetSlideAndTurnAtOnce) {
  for (const double lever : {0.3 * kArm, kArm, 2 * kArm}) {
    GraspHouse house(offCentre(lever));
    wear(house, finger(true));
    const double weight = house.block.mass * house.block.gravity, mu = house.block.material.friction_static;
    const double yields = weight / (2 * mu) * std::hypot(1, lever / kArm);
    grasp(house, 5e-3);
    const Yields seen = release(house, 5e-3, 0);
    EXPECT_NEAR(seen.at, yields, 0.02 * yields) << lever;
    EXPECT_TRUE(seen.slides && seen.turns) << lever;
  }
}

/** A body between two fingers, pushed by springs through friction, rests where it is held: it never gains energy. Each
 * mass but the last was thrown while hands pushed bodies after these had been stepped. */
TEST(Grasp, WhatIsHeldComesToRest) {
  for (const double mass : {0.4, 0.1, 0.02, 0.005}) {
    for (const bool soft : {false, true}) {
      GraspHouse::Block block;
      block.mass = mass;
      block.material.friction_static = 1.5;  // Nothing slips.
      GraspHouse house(block);
      if (soft) wear(house, finger(true));
      for (int i = 0; i <= 100; ++i) {
        house.press(4e-3 * i / 100);
        house.step();
      }
      house.letGo();
      const double sags = mass * block.gravity / (2 * block.material.stiffness);
      double late = 0;
      for (int i = 0; i < 4000; ++i) {
        house.step();
        const double away = std::abs(house.seen().X_WO.p.z() + sags);
        ASSERT_LT(away, 1.1 * sags + 1e-5) << mass << " kg, tick " << i;
        if (i >= 3500) late = std::max(late, away);
      }
      if (soft) {
        EXPECT_LT(late, 0.01 * sags + 1e-7) << mass;
      }
    }
  }
}

/** What both push the same way is not one's to take from the other: it sank through one finger as that got tired. */
TEST(Grasp, TwoFingersBearABlockLevel) {
  for (const double mass : {0.1, 0.4}) {
    GraspHouse::Block block;
    block.mass = mass;
    block.com = {0, 0, -0.06};
    block.material.damping = 1;
    GraspHouse house(block);
    const auto below = [&](double by) {
      for (int d = 0; d < 2; ++d) house.device[d].sample.p = Vec3(d == 0 ? 0.01 : -0.01, 0, -block.size.z() - by);
    };
    below(1e-3);
    for (int i = 0; i < 20; ++i) house.step();
    below(0);
    house.letGo();
    for (int i = 0; i < 3000; ++i) {
      house.step();
      ASSERT_LT((house.seen().X_WO.q * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 1e-6) << mass << " kg, tick " << i;
    }
    for (int d = 0; d < 2; ++d)
      EXPECT_NEAR(house.finger(d).contact.force.z(), -0.5 * mass * block.gravity, 0.02 * mass * block.gravity);
  }
}

/** Springs alone let a block rock between two points for ever, and ever more where a device is late. */
TEST(Grasp, ABlockThatIsKnockedBetweenPointsComesToRest) {
  for (const double stiffness : {500.0, 2000.0}) {
    for (const double mass : {0.1, 0.4}) {
      GraspHouse::Block block;
      block.mass = mass;
      block.material = {stiffness, 1, 0.8, 0.6};
      GraspHouse house(block);
      grasp(house, 6 / stiffness);
      for (int i = 0; i < 10; ++i) {
        house.press(6 / stiffness);
        for (int d = 0; d < 2; ++d) house.device[d].sample.p.z() += d == 0 ? 1e-4 : -1e-4;
        house.step();
      }
      house.press(6 / stiffness);
      const auto rocks = [&] {
        double most = 0;
        for (int i = 0; i < 200; ++i) {
          house.step();
          most = std::max(most, house.body().twist().w.norm());
        }
        return most;
      };
      const double knocked = rocks();
      house.run(2600);
      EXPECT_LT(rocks(), 0.01 * knocked) << stiffness << " N/m, " << mass << " kg";
    }
  }
}

/** A disc that turns on a finger is braked by mu_d P arm alone, and the hand is turned by as much. */
TEST(Grasp, WhatTurnsIsBrakedByTheMomentOfFriction) {
  GraspHouse::Block block;
  block.gravity = 0;
  GraspHouse house(block);
  wear(house, finger(true));
  const double I = MassProperties::ofBox(block.mass, 2 * block.size).inertia_O(0, 0);
  for (int i = 0; i <= 100; ++i) {
    house.press(2e-3 * i / 100);
    house.step();
  }
  hd_object_pose spin = poseMessage(GraspHouse::kBlock, house.seen().X_WO, Twist{Vec3::Zero(), {30, 0, 0}});
  house.send(CommandKind::kObjectPose, spin);
  house.run(20);
  const double w = house.body().twist().w.x(), moment = block.material.friction_dynamic * 2.0 * kArm;
  ASSERT_GT(w, 20);
  house.run(20);
  EXPECT_NEAR(house.body().twist().w.x(), w - 2 * moment / I * 20e-3, 1e-3 * w);
  EXPECT_NEAR(house.finger(0).command.torque.x(), moment, 1e-6);
  EXPECT_NEAR(house.finger(1).command.torque.x(), moment, 1e-6);
  house.run(1000);
  EXPECT_NEAR(house.body().twist().w.x(), 0, 1e-3);
}

/** However fast the fingers are. */
TEST(Grasp, ThePadsViscosityIsNoMoreThanFriction) {
  GraspHouse::Block block;
  block.gravity = 0;
  GraspHouse house(block);
  wear(house, finger(true, 100));
  for (int i = 0; i <= 100; ++i) {
    house.press(2e-3 * i / 100);
    house.step();
  }
  double most = 0;
  for (int i = 1; i <= 10; ++i) {
    house.press(2e-3, Vec3(0, 0, 1e-3 * i));
    house.step();
    const Vec3 force = house.finger(0).contact.force;
    most = std::max(most, std::hypot(force.y(), force.z()));
  }
  EXPECT_LT(most, 0.8 * 2.0 + 1e-9);
  EXPECT_GT(most, 1.5);
}

/** A turn to and fro comes back: printed, eq. 2.31 would count both ways as one. */
TEST(Grasp, AHandThatTurnsToAndFroLeavesTheBlockWhereItWas) {
  GraspHouse::Block block;
  block.gravity = 0;
  GraspHouse house(block);
  wear(house, finger(true));
  const double most = 0.8 * 4 * kArm / 0.1;  // Of the twist that friction bears.
  for (int i = 0; i <= 100; ++i) {
    house.press(4e-3 * i / 100);
    house.step();
  }
  for (int i = 0; i <= 6000; ++i) {
    house.press(4e-3, Vec3::Zero(), 0.5 * std::sin(2 * M_PI * i / 2000));
    house.step();
    ASSERT_NEAR(house.turned(), 0.5 * std::sin(2 * M_PI * i / 2000), 0.3 * most) << i;
  }
  EXPECT_NEAR(house.turned(), 0, 1e-3);
}

/** The same with two fingers whose block goes round by more than a turn, and so do they. */
TEST(Grasp, ABlockIsTurnedRound) {
  GraspHouse::Block block;
  block.gravity = 0;
  GraspHouse house(block);
  wear(house, finger(true));
  for (int i = 0; i <= 100; ++i) {
    house.press(4e-3 * i / 100);
    house.step();
  }
  for (int i = 0; i <= 4000; ++i) {
    house.press(4e-3, Vec3::Zero(), 8.0 * i / 4000);
    house.step();
  }
  house.run(500);
  EXPECT_NEAR(std::remainder(house.turned() - 8.0, 2 * M_PI), 0, 2e-3);
}

/** Pick and place of the thesis (section 2.2.2): each of its 27 cubes is held from the grip m g / (2 mu_s) on. */
TEST(Grasp, TheThesisCubesFallWhereTheirFrictionEnds) {
  constexpr double kFriction[3][2] = {{0.4, 0.3}, {0.8, 0.6}, {1.2, 1.1}};
  for (const double mass : {0.1, 0.2, 0.4}) {
    for (const auto& mu : kFriction) {
      for (const double stiffness : {500.0, 1000.0, 2000.0}) {
        GraspHouse::Block block;
        block.mass = mass;
        block.material = {stiffness, 1, mu[0], mu[1]};
        const double needs = mass * block.gravity / (2 * mu[0]);
        GraspHouse house(block);
        wear(house, finger(true));
        const double depth = 1.3 * needs / stiffness;
        if (depth > 0.4 * block.size.x()) continue;
        grasp(house, depth);
        ASSERT_FALSE(house.finger(0).contact.slip) << mass << " " << mu[0] << " " << stiffness;
        const Yields yields = release(house, depth, 0);
        EXPECT_TRUE(yields.slides);
        EXPECT_NEAR(yields.at, needs, 0.02 * needs) << mass << " " << mu[0] << " " << stiffness;
      }
    }
  }
}

/** A pen held by its ends turns about its axis with nearly no inertia: springs and viscosity of the twist yield to it.
 */
TEST(Grasp, APenHeldByItsEndsComesToRest) {
  for (const double thick : {3.5e-3, 6e-3}) {
    GraspHouse::Block pen;
    pen.size = {0.07, thick, thick};
    pen.com = {0, 0.5 * thick, 0};
    pen.mass = thick < 4e-3 ? 0.005 : 0.02;
    GraspHouse house(pen);
    wear(house, finger(true));
    for (int i = 0; i <= 100; ++i) {
      house.press(2e-3 * i / 100);
      house.step();
    }
    house.letGo();
    house.run(3000);
    EXPECT_LT(house.body().twist().w.norm(), 0.1) << thick;
    EXPECT_LT(std::abs(house.seen().X_WO.p.z()), 1e-3) << thick;
  }
}

/** A tool that touches the block brings it into the tick before the finger has pushed: its push counts all the same. */
TEST(Grasp, WhatAToolTouchesIsPushedByAFingerToo) {
  GraspHouse::Block block;
  block.gravity = 0;
  GraspHouse house(block);
  constexpr std::uint32_t kStick = makeObjectId(3, 1);
  const Vec3 side(0.01, 0.01, 0.01);
  house.device[0].sample.p = {block.size.x() + 0.5 * side.x() + 3e-4, 0, 0};
  house.add(kStick, ShapeKind::kBox, 0.5 * side, {house.device[0].sample.p, Quat::Identity()});
  DeviceInfo able;
  able.max_force = 20;
  able.max_stiffness = 1000;
  able.max_angular_stiffness = 4;
  able.max_damping = 5;
  able.max_angular_damping = 0.01;
  able.actuated_rotation = true;
  house.send(CommandKind::kAttachTool, test::attachBox(kStick, side, able));
  house.run(20);
  ASSERT_TRUE(house.servo->cycle().tool(0).held());
  double given = 0;
  int together = 0;
  for (int i = 0; i < 6; ++i) {
    house.device[1].sample.p = {-block.size.x() + 1e-3, 0, 0};
    house.step();
    if (house.finger(1).contact.object == GraspHouse::kBlock) given -= 1e-3 * house.finger(1).contact.force.x();
    together += house.servo->cycle().bodies().joint().movers() > 1 ? 1 : 0;
  }
  EXPECT_GE(together, 5);
  EXPECT_GT(given, 4e-3);
  EXPECT_NEAR(block.mass * house.body().twist().v.x(), given, 0.02 * given);
}

/** A relief of 3 mm, all black, lies below a finger that is 2 mm deep in the unlowered face: nothing is pressed. */
TEST(Grasp, AReliefThatTakesTheGroundTakesTheMoment) {
  GraspHouse::Block block;
  block.gravity = 0;
  GraspHouse house(block);
  test::TestRelief black(16, 16, [](int, int) { return 0; });
  house.meshes.publishTexture(0, &black.view);
  wear(house, finger(true));
  const auto momentOf = [&](double angle) {
    house.press(2e-3, Vec3::Zero(), angle);
    house.run(20);
    return house.finger(0).command.torque.norm();
  };
  house.press(2e-3);
  house.run(50);
  EXPECT_GT(momentOf(0.02), 1e-4);
  SurfaceParameters surface{};
  surface.relief = 1;
  surface.relief_depth = 0.003;
  surface.relief_size[0] = surface.relief_size[1] = 0.05;
  house.send(CommandKind::kSetSurface, SetSurface{GraspHouse::kBlock, 0, surface});
  house.run(100);
  ASSERT_NE(house.finger(0).contact.object, 0u);
  ASSERT_LT(house.finger(0).command.force.norm(), 1e-9);
  EXPECT_LT(momentOf(0.06), 1e-9);
}

}  // namespace
}  // namespace hapticd
