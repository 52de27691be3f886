// Balls, capsules and cylinders in hollows of meshes: what lies on several walls at once lies on all of them, and
// still.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kWall;
using test::object;
using House = test::ToolHouse;

constexpr double kRadius = 0.008, kBottom = 0.002;

void addHollow(House& house, test::TestMesh& mesh, double friction) {
  house.meshes.publish(3, mesh.view());
  AddObject hollow = object(kWall, ShapeKind::kMesh, Vec3::Zero(), {0, 0, kBottom});
  hollow.shape.mesh = 3;
  hollow.material.friction_static = hollow.material.friction_dynamic = friction;
  house.send(CommandKind::kAddObject, hollow);
}

void holdRound(House& house, ShapeKind kind) {
  house.reshape(kind, {kRadius, 0.01, 0});
  house.hold();
}

/** For a second: how far it moves, how much the force on it changes, and the least gap. */
struct Rest {
  double moved, changed, gap;
};
template <class Gap>
Rest watch(House& house, const Gap& gapOf) {
  const auto force = [&] { return house.servo->cycle().tool(0).last().contact.force; };
  Vec3 place[2] = {house.place().p, house.place().p}, push[2] = {force(), force()};
  double gap = INFINITY;
  for (int i = 0; i < 1000; ++i) {
    house.run(1);
    const Vec3 p = house.place().p, f = force();
    place[0] = place[0].cwiseMin(p);
    place[1] = place[1].cwiseMax(p);
    push[0] = push[0].cwiseMin(f);
    push[1] = push[1].cwiseMax(f);
    gap = std::min(gap, gapOf(p));
  }
  return {(place[1] - place[0]).norm(), (push[1] - push[0]).norm(), gap};
}

TEST(Hollow, WhatIsRoundLiesOnBothWallsOfAGroove) {
  const auto gapOf = [](const Vec3& p) { return (p.z() - kBottom - std::abs(p.x())) / std::sqrt(2.0) - kRadius; };
  for (const ShapeKind kind : {ShapeKind::kSphere, ShapeKind::kCapsule, ShapeKind::kCylinder}) {
    for (const double friction : {0.0, 0.4}) {
      for (const double aside : {0.0, 0.002}) {
        test::TestMesh groove = test::heightMesh(0.03, 12, [](double x, double) { return std::abs(x); });
        House house;
        addHollow(house, groove, friction);
        holdRound(house, kind);
        const Vec3 along(kind == ShapeKind::kSphere ? 0 : EIGEN_PI / 2, 0, 0);
        house.aim({aside, 0, 0.03}, along);
        house.run(500);
        house.aim({aside, 0, 0.005}, along);
        house.run(1200);
        const Rest rest = watch(house, gapOf);
        EXPECT_LT(rest.moved, 1e-6) << static_cast<int>(kind) << " " << friction << " " << aside;
        EXPECT_LT(rest.changed, 1e-3) << static_cast<int>(kind) << " " << friction << " " << aside;
        EXPECT_GT(rest.gap, -1.1 * Tool::kSlop) << static_cast<int>(kind) << " " << friction << " " << aside;
        // Along the groove friction is that of both walls, each of which presses as half the load over cos 45.
        double least = INFINITY, most = -INFINITY;
        for (int i = 0; i < 500; ++i) {
          house.aim({aside, 2e-5 * i, 0.005}, along);
          house.run(1);
          const Vec3 force = house.servo->cycle().tool(0).last().contact.force;
          if (i < 300) continue;
          least = std::min(least, -force.y() / (std::sqrt(2.0) * force.z()));
          most = std::max(most, -force.y() / (std::sqrt(2.0) * force.z()));
          ASSERT_GT(gapOf(house.place().p), -1.1 * Tool::kSlop);
        }
        EXPECT_NEAR(least, friction, 5e-3) << static_cast<int>(kind) << " " << friction << " " << aside;
        EXPECT_NEAR(most, friction, 5e-3) << static_cast<int>(kind) << " " << friction << " " << aside;
      }
    }
  }
}

TEST(Hollow, ABallLiesOnThreeWallsOfACorner) {
  test::TestMesh corner = test::boxMesh({0.04, 0.04, 0.04}, {0, 0, 0.04}, true);
  for (const double friction : {0.0, 0.4}) {
    House house;
    addHollow(house, corner, friction);
    holdRound(house, ShapeKind::kSphere);
    house.aim({0.034, 0.036, 0.005});
    house.run(1500);
    const auto gapOf = [](const Vec3& p) { return std::min({0.04 - p.x(), 0.04 - p.y(), p.z() - kBottom}) - kRadius; };
    const Rest rest = watch(house, gapOf);
    EXPECT_LT(rest.moved, 1e-6) << friction;
    EXPECT_LT(rest.changed, 1e-3) << friction;
    EXPECT_GT(rest.gap, -1.1 * Tool::kSlop) << friction;
    if (friction == 0) {
      EXPECT_EQ(house.servo->cycle().tool(0).last().touching, 3u);
    }
  }
}

/** A block with a groove in its lower side. */
test::TestMesh saddle() {
  test::TestMesh m;
  const double profile[7][2] = {{-0.02, 0},    {0, 0.02},      {0.02, 0},  {0.025, 0},
                                {0.025, 0.03}, {-0.025, 0.03}, {-0.025, 0}};
  for (const double y : {-0.02, 0.02}) {
    for (const auto& p : profile) m.addVertex({p[0], y, p[1]});
  }
  for (std::uint32_t i = 0; i < 7; ++i) m.addQuad(i, i + 7, (i + 1) % 7 + 7, (i + 1) % 7);
  const std::uint32_t ends[5][3] = {{6, 0, 5}, {0, 1, 5}, {1, 4, 5}, {1, 2, 4}, {2, 3, 4}};
  for (const auto& t : ends) {
    m.addTriangle(t[0], t[1], t[2]);
    m.addTriangle(t[0] + 7, t[2] + 7, t[1] + 7);
  }
  m.flags = HD_MESH_CLOSED;
  return m;
}

TEST(Hollow, ASaddleLiesOnABallWithBothItsSides) {
  for (const bool rod : {false, true}) {
    for (const double friction : {0.0, 0.4}) {
      test::TestMesh mesh = saddle();
      House house;
      house.meshes.publish(3, mesh.view());
      house.reshape(ShapeKind::kMesh, Vec3::Zero(), 3);
      AddObject ball =
          object(kWall, rod ? ShapeKind::kCapsule : ShapeKind::kSphere, {kRadius, 0.1, 0}, {0, 0.0013, 0.02});
      store(fromRotationVector({EIGEN_PI / 2, 0, 0}), ball.q);
      ball.material.friction_static = ball.material.friction_dynamic = friction;
      house.send(CommandKind::kAddObject, ball);
      house.hold();
      house.aim({0.001, 0, 0.008});
      house.run(1500);
      const auto gapOf = [&](const Vec3& p) {
        const Vec3 x = house.place().q.conjugate() * (Vec3(0, p.y(), 0.02) - p);
        return (0.02 - x.z() - std::abs(x.x())) / std::sqrt(2.0) - kRadius;
      };
      const Rest rest = watch(house, gapOf);
      EXPECT_LT(rest.moved, 1e-6) << rod << " " << friction;
      EXPECT_LT(rest.changed, 2e-3) << rod << " " << friction;
      EXPECT_GT(rest.gap, -1.5 * Tool::kSlop) << rod << " " << friction;
      EXPECT_GT(house.servo->cycle().tool(0).last().contact.force.z(), 0.5) << rod << " " << friction;
    }
  }
}

TEST(Hollow, ABallThatFallsIntoAGrooveComesToRest) {
  test::TestMesh groove = test::heightMesh(0.03, 12, [](double x, double) { return std::abs(x); });
  const std::uint32_t ball = makeObjectId(10, 1);
  House house;
  addHollow(house, groove, 0.4);
  house.send(CommandKind::kAddObject, object(ball, ShapeKind::kSphere, {kRadius, 0, 0}, {0.003, 0, 0.02}));
  SetBody body{ball, 1, 0.2, {}, {}, 0};
  for (int i = 0; i < 3; ++i) body.inertia[i] = 0.4 * body.mass * kRadius * kRadius;
  house.send(CommandKind::kSetBody, body);
  house.send(CommandKind::kSetGravity, SetGravity{{0, 0, -9.81}});
  house.run(3000);
  EXPECT_TRUE(house.servo->cycle().bodies().body(0).asleep());
  const Vec3 p = house.servo->cycle().bodies().body(0).body.com();
  EXPECT_NEAR(p.x(), 0, 20e-6);
  EXPECT_NEAR(p.z(), kBottom + std::sqrt(2.0) * kRadius, 20e-6);
}

}  // namespace
}  // namespace hapticd
