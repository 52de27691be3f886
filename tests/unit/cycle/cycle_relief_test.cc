// A relief is a part of its surface: what it stores and gives back is watched with it, and costs a hand nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "rt/base/rotation.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/stepped_cycle.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kGround = makeObjectId(1, 1);
constexpr double kSize = 0.032;  // Of the pictures [m].

/** An armed hand over a floor, z = 0, with a relief: `grey` of the place seen from its left edge [m]. */
class OverRelief : public test::SteppedCycle {
 public:
  OverRelief(const std::function<double(double)>& grey, double depth, bool passivity = true)
      : SteppedCycle(config(passivity)), picture_(256, 256, [&](auto x, auto) { return grey(x * kSize / 256); }) {
    meshes.publishTexture(0, &picture_.view);
    meshes.publish(0, sheet_.deformableView());
    surface_.relief = 1;
    surface_.relief_depth = depth;
    surface_.relief_size[0] = surface_.relief_size[1] = kSize;
    arm();
  }
  void addFloor(ShapeKind kind, double damping = 0) {
    add(test::solid(kGround, kind, {1000, damping, 0, 0}));
    giveRelief();
  }
  /** Plain, facing -x, at that x. */
  void addWall(double x) {
    const Pose X{{x, 0, 0}, fromRotationVector(-std::numbers::pi / 2 * Vec3::UnitY())};
    add(test::solid(makeObjectId(2, 1), ShapeKind::kPlane, {1000, 5, 0, 0}, X));
  }
  void giveRelief() { put(CommandKind::kSetSurface, SetSurface{kGround, 0, surface_}); }
  void takeReliefAway() { put(CommandKind::kSetSurface, SetSurface{kGround, 0, {}}); }
  void moveFloor(const Vec3& to, const Vec3& v) {
    put(CommandKind::kObjectPose, poseMessage(kGround, {to, Quat::Identity()}, {v, Vec3::Zero()}));
  }
  /** By its vertices, so far along x from where they were made. */
  void slideSheet(double x) {
    hd_object_vertices order{};
    order.object = kGround;
    for (std::uint32_t i = 0; i < made_.size(); ++i) {
      order.move[order.count++] = {i, {static_cast<float>(made_[i][0] + x), made_[i][1], made_[i][2]}};
    }
    put(CommandKind::kObjectVertices, order);
  }
  const GuardOutput& at(const Vec3& p) { return SteppedCycle::at(p).guard; }
  /** From the air down to p, within 0.2 s. */
  const GuardOutput& come(const Vec3& p) {
    for (int i = 0; i <= 200; ++i) at({p.x(), p.y(), 0.002 + (p.z() - 0.002) * i / 200});
    return output->device[0].guard;
  }

 private:
  static CycleConfig config(bool passivity) {
    CycleConfig config = test::openConfig(100);
    config.guard[0].passivity = passivity;
    return config;
  }

  test::TestRelief picture_;
  test::TestMesh sheet_ = test::heightMesh(0.5, 1, [](double, double) { return 0.0; });
  std::vector<std::array<float, 3>> made_ = sheet_.vertices;
  SurfaceParameters surface_{};
};

double black(double) { return 0; }
double slope(double x) { return x / kSize; }

/** However it moves there: nothing is touched, so nothing may leak and nothing is damped. */
TEST(CycleRelief, AboveTheGroundOfAHollowNothingIsFelt) {
  for (const double damping : {0.0, 5.0}) {
    OverRelief hand(black, 0.01);
    hand.addFloor(ShapeKind::kPlane, damping);
    for (int i = 0; i < 3000; ++i) {
      const double t = 1e-3 * i;
      const GuardOutput& out = hand.at({0.01 * std::sin(5 * t), 0, 0.001 - 0.005 * (1 - std::cos(30 * t))});
      ASSERT_EQ(out.command.force, Vec3::Zero()) << t;
      ASSERT_FALSE(out.flags & HD_SAMPLE_PASSIVITY) << t;
      ASSERT_EQ(out.energy, 0) << t;
    }
  }
}

/** Nor beside a wall that does press, and takes energy: of the corner's springs the floor's holds nothing to pay with.
 */
TEST(CycleRelief, AHollowBesideAWallStoresNothing) {
  OverRelief hand(black, 0.01);
  hand.addFloor(ShapeKind::kPlane);
  hand.addWall(0.01);
  hand.come({0, 0, -0.001});
  for (int i = 0; i <= 200; ++i) hand.at({6e-5 * i, 0, -0.001});
  for (int i = 0; i < 3000; ++i) {
    const double t = 1e-3 * i, deep = 0.002 + 0.001 * std::sin(40 * t);
    const GuardOutput& out = hand.at({0.01 + deep, 0, -0.005 + 0.004 * std::cos(30 * t)});
    ASSERT_LT(out.command.force.x(), 0) << t;
    ASSERT_LE(out.energy, Passivity::kMargin + 500 * deep * deep + 1e-9) << t;
  }
}

/** A light hand lies in the valleys of waves, whose walls are stiff across: sampled they give what the guard takes. */
TEST(CycleRelief, WhatASampledReliefGivesIsTakenBack) {
  for (const double wave : {8e-3, 4e-3}) {
    double given[2] = {};
    for (const bool passivity : {false, true}) {
      OverRelief relief([&](double x) { return 0.5 + 0.5 * std::sin(2 * std::numbers::pi * x / wave); },
                        wave / std::numbers::pi, passivity);
      relief.addFloor(ShapeKind::kPlane, 0.5);
      Vec3 x(0.3 * wave, 0, 0.002), v = Vec3::Zero();
      for (int i = 0; i < 3000; ++i) {
        const Vec3 f = relief.at(x).command.force, before = x;
        for (int k = 0; k < 20; ++k) {  // 150 g, pressed down with 2 N.
          v += 5e-5 / 0.15 * (f - Vec3(20 * (x.x() - 0.3 * wave), 20 * x.y(), 2) - v);
          x += 5e-5 * v;
        }
        given[passivity] += f.dot(x - before);
      }
    }
    EXPECT_GT(given[0], 5e-3) << wave << ": the port is active";
    EXPECT_LT(given[1], 0.5 * given[0]) << wave;
  }
}

/** 5 mm below the floor that is no hollow any more it holds 12.5 mJ, which the client has put in. */
TEST(CycleRelief, AReliefThatIsTakenAwayUnderAHandIsTheClientsDoing) {
  OverRelief hand(black, 0.01);
  hand.addFloor(ShapeKind::kPlane);
  hand.come({0, 0, -0.005});
  hand.takeReliefAway();
  ASSERT_NEAR(hand.at({0, 0, -0.005}).command.force.z(), 5, 1e-6);
  double least = 0;
  for (int i = 0; i < 600; ++i) {
    const GuardOutput& out = hand.at({0, 0, -0.005 + 1e-5 * i});
    least = std::min(least, out.energy);
    ASSERT_EQ(out.flags & HD_SAMPLE_PASSIVITY, 0u) << i;
  }
  EXPECT_GT(least, -1e-4);
}

/** What holds 0.5 mJ and then 12.5 mJ was given 12; taken back, they are no more than what is left can give. */
TEST(CycleRelief, AnotherReliefIsChargedForWhatItAddsAndGetsNothingForWhatItTakes) {
  constexpr double kShallow = 0.5 * 1000 * 1e-6, kDeep = 0.5 * 1000 * 25e-6;
  OverRelief hand(black, 0.004);
  hand.addFloor(ShapeKind::kPlane);
  const double before = hand.come({0, 0, -0.005}).energy;
  ASSERT_NEAR(before, kShallow, Passivity::kMargin);
  hand.takeReliefAway();
  for (int i = 0; i < 5; ++i) hand.at({0, 0, -0.005});
  EXPECT_NEAR(hand.output->device[0].guard.energy, before + kDeep - kShallow, 1e-6);
  hand.giveRelief();
  for (int i = 0; i < 5; ++i) hand.at({0, 0, -0.005});
  EXPECT_NEAR(hand.output->device[0].guard.energy, kShallow + Passivity::kMargin, 1e-6);
  hand.takeReliefAway();
  for (int i = 0; i < 5; ++i) hand.at({0, 0, -0.005});
  EXPECT_NEAR(hand.output->device[0].guard.energy, kDeep + Passivity::kMargin, 1e-6) << "and again";
}

/**
 * A slope of 1/4 that travels lifts a hand on it, or lets it down, at a quarter of its speed: that work is the body's.
 * The picture does not go with the vertices of a sheet: who moves those does nothing to a hand that lies on a slope.
 */
TEST(CycleRelief, WhatMovesUnderAHandIsChargedForWhatTheReliefDoes) {
  for (const double speed : {-0.05, 0.05}) {
    for (const bool by_vertices : {false, true}) {
      OverRelief hand(slope, 0.25 * kSize);
      hand.addFloor(by_vertices ? ShapeKind::kMesh : ShapeKind::kPlane);
      const double z = -0.125 * kSize - 1e-3;  // A millimetre below the ground in its middle.
      hand.come({0, 0, z});
      const double before = hand.at({0, 0, z}).energy;
      for (int i = 1; i <= 200; ++i) {
        const double way = 1e-3 * speed * i;
        if (by_vertices && i % 16 == 0) hand.slideSheet(way);
        if (!by_vertices) hand.moveFloor({way, 0, 0}, {speed, 0, 0});
        const GuardOutput& out = hand.at({0, 0, by_vertices ? z : z - 0.25 * way});
        ASSERT_NEAR(out.command.force.z(), 1, 0.02);
        ASSERT_NEAR(out.energy, before, 1e-4) << i << " " << speed << " " << by_vertices;
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
