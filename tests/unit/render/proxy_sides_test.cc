// One-sided and two-sided sheets: which face stops the hand, and what happens when that changes.
#include <gtest/gtest.h>

#include <random>

#include "tests/support/seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kOneSided;
using test::kTwoSided;
using test::TestMesh;
using test::TestScene;

const hd_material kRubber{1000, 2, 0.6, 0.4};

/** A flat sheet z = 0, 10 cm wide, its front up. */
TestMesh sheet() {
  return test::heightMesh(0.05, 8, [](double, double) { return 0.0; });
}

Vec3 mirrored(const Vec3& x) { return {x.x(), x.y(), -x.z()}; }

/** A hand that starts on a sheet, or about which one appears, is on one side of it: it is held on one way, not on both.
 */
TEST(ProxySides, AHandThatStartsOnASheetIsOnOneSideOfIt) {
  TestMesh flat = sheet();
  MeshView* const view = flat.view();
  const double cell = 0.0125;  // [m]
  for (const bool appears : {false, true}) {
    for (const double radius : {0.0, 0.002}) {
      for (const Vec3& at : {Vec3(0, 0, 0), Vec3(0.5 * cell, 0, 0), Vec3(0.3 * cell, 0.2 * cell, 0)}) {
        for (const Pose& X :
             {Pose{}, Pose{Vec3(0.1, 0.2, 0.3), Quat(Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()))}}) {
          int held = 0;
          for (const double way : {0.003, -0.003}) {
            TestScene t(radius);
            if (appears) t.tick(X * at);
            t.addMesh(view, X, kRubber, kTwoSided);
            t.tick(X * at);
            held += t.tick(X * (at + Vec3(0, 0, way))).object != 0;
          }
          EXPECT_EQ(held, 1) << appears << " " << radius << " " << at.transpose();
        }
      }
    }
  }
}

/** Nor does one that comes to stand on the sheet itself, from either side, forget where it came from, or feel a touch.
 */
TEST(ProxySides, AHandThatStopsOnASheetIsOnTheSideItCameFrom) {
  TestMesh flat = sheet();
  MeshView* const view = flat.view();
  for (const double from : {1.0, -1.0}) {
    for (const Vec3& at : {Vec3(0.001, 0.002, 0), Vec3(0.00625, 0, 0), Vec3(0.0125, 0.0125, 0)}) {
      TestScene t;
      t.addMesh(view, {}, kRubber, kTwoSided);
      const auto force = [&](double height) { return from * t.tick(at + Vec3(0, 0, from * height)).force.z(); };
      for (const double height : {0.003, 0.001, 0.0, 0.0, 0.001, 0.005, 0.0}) {
        EXPECT_EQ(force(height), 0) << at.transpose() << " " << height;
        EXPECT_EQ(t.contact.object, 0u);
      }
      EXPECT_NEAR(force(-0.002), 2, 1e-9);
      EXPECT_EQ(force(0), 0);
      EXPECT_EQ(force(0.003), 0);
      EXPECT_NEAR(force(-0.002), 2, 1e-9);
    }
  }
}

/** One that comes over the border in the plane of the sheet, where nobody knows from which side, feels nothing there.
 */
TEST(ProxySides, AHandThatComesInThePlaneOfASheetIsNotHeldFromBothSides) {
  TestMesh flat = sheet();
  MeshView* const view = flat.view();
  for (const double mu : {0.0, 0.5}) {
    for (const double y : {0.0, 0.003, 0.0125}) {
      for (const Pose& X :
           {Pose{}, Pose{Vec3(0.1, 0.2, 0.3), Quat(Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()))}}) {
        int held = 0;
        for (const double way : {0.01, -0.01}) {
          TestScene t;
          t.addMesh(view, X, {1000, 0, mu, 0.7 * mu}, kTwoSided);
          for (int i = 0; i <= 100; ++i)
            ASSERT_LT(t.tick(X * Vec3(-0.07 + 0.0009 * i, y, 0)).force.norm(), 1e-9) << mu << " " << y << " " << i;
          for (int i = 0; i <= 100; ++i) t.tick(X * Vec3(0.02 + 1e-4 * i, y, 0.01 * i * way));
          held += t.contact.object != 0;
        }
        EXPECT_LE(held, 1) << mu << " " << y;
      }
    }
  }
}

/** The back of a two-sided sheet feels as its front does: stiffness, damping, friction. */
TEST(ProxySides, TheBackOfATwoSidedSheetIsTheMirrorOfItsFront) {
  TestMesh a = sheet(), b = sheet();
  TestScene front, back;
  front.addMesh(a.view(), {}, kRubber, kTwoSided);
  back.addMesh(b.view(), {}, kRubber, kTwoSided);
  std::mt19937 random(seedOf(4));
  std::uniform_real_distribution<double> number(-1, 1);
  Vec3 x(0, 0, 0.005), v = Vec3::Zero();
  int felt = 0, slipped = 0;
  for (int i = 0; i < 20000; ++i) {
    v = 0.98 * v + 0.01 * Vec3(number(random), number(random), number(random));
    x += 1e-3 * v - 0.002 * x;
    const SurfaceContact& f = front.tick(x, v);
    const SurfaceContact& g = back.tick(mirrored(x), mirrored(v));
    ASSERT_LT((f.force - mirrored(g.force)).norm(), 1e-9) << i;
    ASSERT_EQ(f.slip, g.slip) << i;
    felt += f.object != 0;
    slipped += f.slip;
  }
  EXPECT_GT(felt, 2000);
  EXPECT_GT(slipped, 100);
  EXPECT_LT(slipped, felt);
}

/** A one-sided sheet lets the hand through from behind, and holds it once it comes from the front. */
TEST(ProxySides, AOneSidedSheetStopsFromItsFrontAlone) {
  TestMesh mesh = sheet();
  TestScene t;
  t.addMesh(mesh.view(), {}, kRubber, kOneSided);
  for (int i = 0; i <= 40; ++i) EXPECT_EQ(t.tick({0.013, 0.007, -0.01 + 0.0005 * i}).object, 0u) << i;
  for (int i = 0; i < 20; ++i) t.tick({0.013, 0.007, 0.0095 - 0.0005 * i});
  EXPECT_EQ(t.contact.object, 0u);
  EXPECT_NEAR(t.tick({0.013, 0.007, -0.002}).force.z(), 2, 1e-9);
}

/** Who rolls over its border is let go where the ball's centre passes behind it, while the ground moves too. */
TEST(ProxySides, TheBorderOfAOneSidedSheetHoldsNoBallFromBehind) {
  for (const bool moves : {false, true}) {
    TestMesh mesh = sheet();
    double border = 0;
    for (const auto& v : mesh.vertices) border = std::max(border, double{v[0]});
    TestScene t(0.005);
    t.addMesh(mesh.view());
    const std::uint32_t ground = t.add(ShapeKind::kPlane, Vec3::Zero(), {Vec3(0, 0, -1), Quat::Identity()});
    t.tick({border, 0.007, 0.02});
    for (int degrees = 90; degrees >= -200; --degrees) {
      const double a = degrees * M_PI / 180;
      if (moves) t.pose(ground, {Vec3(0, 1e-3 * (degrees & 1), -1), Quat::Identity()});
      t.tick({border + 0.003 * std::cos(a), 0.007, 0.003 * std::sin(a)});
      ASSERT_NEAR(t.contact.force.norm(), degrees >= 0 ? 2 : 0, 1e-6) << degrees << " " << moves;
    }
  }
}

/** Taking the back away sets the hand free in the same tick; giving it back neither catches nor throws it. */
TEST(ProxySides, ChangingSidesInContactSetsFreeAndNeverPulls) {
  TestMesh mesh = sheet();
  TestScene t;
  const std::uint32_t id = t.addMesh(mesh.view(), {}, {1000, 0, 0, 0}, kTwoSided);
  const Vec3 above(0.013, 0.007, 0.002);
  t.tick({0.013, 0.007, -0.01});
  EXPECT_NEAR(t.tick(above).force.z(), -2, 1e-9) << "pressed up against the back";
  t.flags(id, HD_OBJECT_TWO_SIDED, 0);
  EXPECT_EQ(t.tick(above).force, Vec3::Zero());
  EXPECT_EQ(t.contact.object, 0u);
  t.flags(id, HD_OBJECT_TWO_SIDED, HD_OBJECT_TWO_SIDED);
  EXPECT_EQ(t.tick(above).force, Vec3::Zero()) << "now it is on the front's side";
  EXPECT_NEAR(t.tick({0.013, 0.007, -0.001}).force.z(), 1, 1e-9);
}

/** A two-sided sheet that moves carries a resting hand along, up and down. */
TEST(ProxySides, AMovingTwoSidedSheetPushesBothWays) {
  for (const double side : {1.0, -1.0}) {
    TestMesh mesh = sheet();
    TestScene t;
    const std::uint32_t id = t.addMesh(mesh.view(), {}, {1000, 0, 0, 0}, kTwoSided);
    const Vec3 hand(0.013, 0.007, 0.0015 * side);
    t.tick(hand);
    for (int i = 1; i <= 30; ++i) {
      t.pose(id, {Vec3(0, 0, 1e-4 * i * side), Quat::Identity()});
      t.tick(hand);
      const double depth = std::max(0.0, 1e-4 * i - 0.0015);
      ASSERT_NEAR(t.contact.force.z(), side * 1000 * depth, 1e-9) << i;
    }
  }
}

}  // namespace
}  // namespace hapticd
