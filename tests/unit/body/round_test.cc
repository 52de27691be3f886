// Balls and capsules that turn between two answers of the collide thread: they roll, spin and slide as round things do.
#include "rt/collide/round.h"

#include <gtest/gtest.h>

#include <cmath>

#include "rt/collide/feature.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kFloor;
using test::kTool;
using test::kWall;
using test::object;
using House = test::ToolHouse;

constexpr double kGravity = 9.81, kRoundRadius = 0.02;
const std::uint32_t kRoller = makeObjectId(10, 1);

/** Lies on the floor, its axis along y. */
const Pose kLies{{0, 1, kRoundRadius}, fromRotationVector({-EIGEN_PI / 2, 0, 0})};

void addRoller(House& house, ShapeKind kind, const Vec3& gravity) {
  AddObject round = object(kRoller, kind, {kRoundRadius, kind == ShapeKind::kSphere ? 0 : 0.03, 0}, kLies.p);
  store(kLies.q, round.q);
  house.send(CommandKind::kAddObject, round);
  SetBody body{kRoller, 1, 0.2, {}, {}, 0};
  for (int i = 0; i < 3; ++i) body.inertia[i] = 0.4 * body.mass * kRoundRadius * kRoundRadius;
  house.send(CommandKind::kSetBody, body);
  house.send(CommandKind::kSetGravity, SetGravity{{gravity.x(), gravity.y(), gravity.z()}});
  house.run(50);
}

void start(House& house, double v, double w) {
  hd_object_pose pose{kRoller, 0, {}, {}, {static_cast<float>(v)}, {0, static_cast<float>(w)}};
  store(kLies.p, pose.p);
  store(kLies.q, pose.q);
  house.send(CommandKind::kObjectPose, pose);
  house.run(1);
}

const RigidBody& roller(const House& house) { return house.servo->cycle().bodies().body(0).body; }

TEST(Round, RollsOnAtItsSpeedAndDoesNotSinkIn) {
  for (const ShapeKind kind : {ShapeKind::kSphere, ShapeKind::kCapsule}) {
    for (const double v : {0.02, 0.2, 1.0}) {
      House house;
      addRoller(house, kind, {0, 0, -kGravity});
      start(house, v, v / kRoundRadius);
      house.run(1500);
      EXPECT_NEAR(roller(house).twist().v.x(), v, 1e-3 * v);
      EXPECT_NEAR(roller(house).twist().w.y() * kRoundRadius, v, 1e-3 * v);
      EXPECT_NEAR(roller(house).com().z(), kRoundRadius, 1e-7);
    }
  }
}

/** Its points are a prism's of 32 sides, which would rock to and fro on one of them. */
TEST(Round, ACylinderRollsTooAndStandsOnItsEnd) {
  for (const double v : {0.02, 0.2, 0.5}) {
    House house;
    addRoller(house, ShapeKind::kCylinder, {0, 0, -kGravity});
    start(house, v, v / kRoundRadius);
    house.run(1500);
    EXPECT_NEAR(roller(house).twist().v.x(), v, 0.01 * v);
    EXPECT_NEAR(roller(house).twist().w.y() * kRoundRadius, v, 0.01 * v);
    EXPECT_NEAR(roller(house).com().z(), kRoundRadius, 1.1e-5);
  }
  House house;
  addRoller(house, ShapeKind::kCylinder, {0, 0, -kGravity});
  house.send(CommandKind::kObjectPose, hd_object_pose{kRoller, 0, {0, 1, 0.0301}, {1}, {}, {}});
  house.run(1000);
  EXPECT_NEAR(roller(house).com().z(), 0.03, 1.1e-5);
  EXPECT_TRUE(house.servo->cycle().bodies().body(0).asleep());
}

TEST(Round, RollsDownAsTheClosedForm) {
  for (const double slope : {0.02, 0.1, 0.3}) {
    House house;
    addRoller(house, ShapeKind::kSphere, kGravity * Vec3(std::sin(slope), 0, -std::cos(slope)));
    house.run(50);
    const double before = roller(house).twist().v.x();
    house.run(500);
    const double want = 5.0 / 7 * kGravity * std::sin(slope);
    EXPECT_NEAR((roller(house).twist().v.x() - before) / 0.5, want, 1e-3 * want) << slope;
  }
}

TEST(Round, OneThatSpinsInPlaceEndsRollingAsTheClosedForm) {
  for (const double w : {5.0, 20.0, 100.0}) {
    House house;
    addRoller(house, ShapeKind::kSphere, {0, 0, -kGravity});
    start(house, 0, w);
    house.run(1500);
    const double want = 2.0 / 7 * w * kRoundRadius;
    EXPECT_NEAR(roller(house).twist().v.x(), want, 2e-3 * want) << w;
  }
}

/** Its lowest point over a plane is not that over a ball or an edge: the cylinder hung in the air, or fell to and fro.
 */
TEST(Round, ACylinderLiesOnABallOfAMeshAndOnAnEdge) {
  for (const double radius : {0.003, 0.008, 0.015}) {
    for (const bool edge : {false, true}) {
      const Vec3 middle(0, 0, edge ? 0.015 : 0.01);
      test::TestMesh mesh = test::sphereMesh(0.02, 50);
      House house;
      house.meshes.publish(3, mesh.view());
      AddObject obstacle = object(kWall, edge ? ShapeKind::kBox : ShapeKind::kMesh,
                                  edge ? Vec3(0.05, 0.01, 0.01) : Vec3(0, 0, 0), middle);
      if (edge) store(fromRotationVector({EIGEN_PI / 4, 0, 0}), obstacle.q);
      if (!edge) obstacle.shape.mesh = 3;
      obstacle.material.friction_static = obstacle.material.friction_dynamic = 0;
      house.send(CommandKind::kAddObject, obstacle);
      const SetShape shape{kTool, 0, {static_cast<std::uint32_t>(ShapeKind::kCylinder), 0, {radius, 0.02}}};
      house.send(CommandKind::kSetShape, shape);
      const Vec3 lying(EIGEN_PI / 2, 0.2, 0);
      house.aim({0, 0.001, 0.05}, lying);
      house.run(800);
      house.hold();
      house.aim({0, 0.001, 0.027 + radius}, lying);
      house.run(1500);
      const Vec3 top = middle + Vec3(0, 0, edge ? std::sqrt(2.0) * 0.01 : 0);
      Vec3 least = house.place().p, most = least;
      for (int i = 0; i < 500; ++i) {
        house.run(1);
        const Vec3 axis = house.place().q * Vec3::UnitZ(), away = house.place().p - top;
        const double apart = edge ? std::abs(away.dot(axis.cross(Vec3::UnitX()).normalized())) - radius
                                  : away.cross(axis).norm() - radius - 0.02;
        ASSERT_LT(apart, 2e-6) << radius << " " << edge;
        ASSERT_GT(apart, edge ? -1.5 * Tool::kSlop : -50e-6) << radius << " " << edge << ": of the ball's facets 20 um";
        least = least.cwiseMin(house.place().p);
        most = most.cwiseMax(house.place().p);
      }
      EXPECT_GT(house.servo->cycle().tool(0).last().contact.force.z(), 0.3) << radius << " " << edge;
      EXPECT_LT((most - least).norm(), 2e-6) << radius << " " << edge;
    }
  }
}

TEST(Round, AHeldBallThatTurnsIsStillABall) {
  const double radius = 0.01;
  House house;
  house.send(CommandKind::kObjectMaterial, hd_object_material{kFloor, 0, {1000, 0, 0, 0}});
  house.send(CommandKind::kSetShape, SetShape{kTool, 0, {static_cast<std::uint32_t>(ShapeKind::kSphere), 0, {radius}}});
  house.hold();
  house.aim({0, 0, -0.02});
  house.run(800);
  for (int i = 0; i < 1000; ++i) {
    house.aim({0, 0, -0.02}, {0, 1.2 * std::sin(0.02 * i), 0});
    house.run(1);
    ASSERT_NEAR(house.place().p.z(), radius, 1e-6) << i;
    const Wrench& contact = house.servo->cycle().tool(0).last().contact;
    ASSERT_LT(std::abs(contact.torque.y()), 1e-9 * contact.force.z()) << "through its middle" << i;
  }
}

TEST(Round, ABallThatSpinsUnderAToolPushesItStraightUp) {
  for (const double w : {1.0, 5.0, 20.0}) {
    House house;
    AddObject ball = object(kWall, ShapeKind::kSphere, {0.03, 0, 0}, {0, 0, 0});
    ball.material.friction_static = ball.material.friction_dynamic = 0;
    house.send(CommandKind::kAddObject, ball);
    house.hold();
    house.aim({0, 0, 0.033});
    double across = 0, up = 0;
    for (int i = 0; i < 2000; ++i) {
      hd_object_pose pose{kWall, 0, {}, {}, {}, {0, static_cast<float>(w)}};
      store(fromRotationVector({0, w * 1e-3 * i, 0}), pose.q);
      house.send(CommandKind::kObjectPose, pose);
      house.run(1);
      if (i < 1000) continue;
      across += house.servo->cycle().tool(0).last().contact.force.x();
      up += house.servo->cycle().tool(0).last().contact.force.z();
    }
    EXPECT_LT(std::abs(across), 1e-3 * up) << w;
  }
}

/** Deep in a mesh it is held by the plane that was found, and still by its centre, however it has rolled. */
TEST(Round, ABallDeepInAMeshIsMetByItsCentre) {
  test::TestMesh block = test::boxMesh({0.02, 0.02, 0.02});
  block.flags = HD_MESH_CLOSED;
  Shape mesh{ShapeKind::kMesh, Vec3::Zero()};
  mesh.mesh = block.view();
  const Shape ball{ShapeKind::kSphere, {0.01, 0, 0}};
  for (const double height : {0.021, 0.019}) {  // Of the centre: above and below the surface.
    Touch touch;
    touch.n = Vec3(0, 0, 1);
    touch.r_a = Vec3(0.006, 0, -0.008);  // A point that was lowest before the ball rolled on.
    touch.gap = height - 0.008 - 0.02;
    std::uint32_t top = 0;
    while (faceNormal(*mesh.mesh, top).z() < 0.5) ++top;
    rollTo({ball, {Vec3(0.001, 0.002, height), Quat::Identity()}}, meshEdgeFeature(top, 0), {mesh, Pose{}},
           {0.001, 0.002, height}, Vec3::Zero(), touch);
    EXPECT_LT((touch.r_a - Vec3(0, 0, -0.01)).norm(), 1e-9) << height;
    EXPECT_NEAR(touch.gap, height - 0.03, 1e-9);
  }
}

}  // namespace
}  // namespace hapticd
